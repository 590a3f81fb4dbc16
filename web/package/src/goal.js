// Checks the options that the modifiers for glTF-Transform and three.js share.

import { checkNames } from './names.js';

const NAMES = ['ratio', 'faces', 'error', 'lockBorder', 'move', 'progress', 'signal', 'worker'];

/**
 * Checks the caller's options and adds defaults.
 *
 * @returns {{ratio: number, faces?: number, error: number, lockBorder: boolean, move: boolean}}
 */
export function readGoal(options) {
  checkNames(options, NAMES);
  const { ratio, faces, error = Infinity, lockBorder = false, move = true } = options;
  const isCount = Number.isInteger(faces) && faces >= 0;
  if (ratio !== undefined && !(ratio >= 0 && ratio <= 1)) throw new RangeError(`ratio: ${ratio} is not between 0 and 1`);
  if (faces !== undefined && !isCount) throw new RangeError(`faces: ${faces} is not a whole number of at least 0`);
  if (!(error >= 0)) throw new RangeError(`error: ${error} is not at least 0`);
  if (ratio !== undefined && faces !== undefined) throw new TypeError('ratio and faces: give one of them');
  if (ratio === undefined && faces === undefined && error === Infinity) throw new TypeError('give ratio, faces or error, such as { ratio: 0.1 }');
  return { ratio: ratio ?? 0, faces, error, lockBorder, move };
}

// Reads the wished size and options, and derives titles and file names from them.

import { count } from '../../../cli/viewer/src/words.js';
import { stemOf } from './files.js';

/** Shares of the vertices of the levels; the first is made at once, the others in the background. */
export const LEVELS = [0.1, 0.5, 0.25, 0.05, 0.02];

/** Smallest and largest share of the slider. */
const [LEAST, MOST] = [0.002, 1];

const SWITCHES = ['keep_features', 'lock_boundaries', 'subset'];
const CHOICES = { optimize: 'balanced', effort: 'standard' };

const at = (id) => document.getElementById(id);

/** Returns the share at a position of the slider, rounded to two digits. */
export function shareAt(place) {
  const share = LEAST * (MOST / LEAST) ** place;
  const near = LEVELS.find((level) => Math.abs(placeOfShare(level) - place) < 0.004);
  return near ?? Number(share.toPrecision(2));
}

/** Returns the position of a share on the slider, 0 to 1. */
export function placeOfShare(share) {
  return Math.log(share / LEAST) / Math.log(MOST / LEAST);
}

/** Formats a share in percent. */
export function percent(share) {
  return `${Number((100 * share).toPrecision(3))} %`;
}

/** Returns the options that differ from the program's defaults. */
export function readOptions() {
  const chosen = Object.entries(CHOICES).filter(([id, usual]) => at(id).value !== usual).map(([id]) => [id, at(id).value]);
  const switched = SWITCHES.filter((id) => at(id).checked).map((id) => [id, true]);
  return Object.fromEntries([...chosen, ...switched]);
}

/** Returns the current `{wish}`, or the reason `{why}` it is invalid. */
export function readWish() {
  const options = readOptions();
  const number = (id) => at(id).valueAsNumber;
  if (at('by').value === 'ratio') return { wish: wishOfShare(shareAt(number('share')), options) };
  if (at('by').value === 'faces') {
    const faces = Math.round(number('faces'));
    return faces >= 1 ? { wish: makeWish({ faces }, `${count(faces)} faces`, `${faces}-faces`, options) } : { why: 'Give a number of faces.' };
  }
  const error = number('error');
  if (!(error > 0)) return { why: 'Give a distance above 0 %.' };
  return { wish: makeWish({ error: `${error}%` }, `within ${error} %`, `within-${error}`, options) };
}

/** Returns the wish for a share of the vertices under options. */
export function wishOfShare(share, options) {
  return makeWish({ ratio: share }, percent(share), percent(share).replace(' %', ''), options);
}

function makeWish(size, title, suffix, options) {
  return { size, options, title, suffix, key: JSON.stringify([size, options]) };
}

/** Returns the file name of a wish's result. */
export function nameOfResult(name, { suffix }, ending) {
  return `${stemOf(name)}-${suffix}.${ending}`;
}

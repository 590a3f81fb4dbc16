// Simplifies the parts of a surface together: those that different materials cover, which meet at equal positions and stay joined there.

import { NeuralMeshError } from './runtime.js';
import { compactIndices } from './remap.js';
import { simplifyIndices } from './simplifier.js';

/** What the difference of an attribute counts against a distance, where the surface's extent is 1. */
const WEIGHTS = { normal: [3, 0.5], uv: [2, 0.5], color: [3, 0.5] };

/** Reads how far a surface is to be simplified: options of callers, checked. */
export function readGoal({ ratio, faces, error = Infinity, lockBorder = false }) {
  if (ratio !== undefined && !(ratio >= 0 && ratio <= 1)) throw new RangeError(`ratio: ${ratio} is not between 0 and 1`);
  const isCount = Number.isInteger(faces) && faces >= 0;
  if (faces !== undefined && !isCount) throw new RangeError(`faces: ${faces} is no whole number of at least 0`);
  if (!(error >= 0)) throw new RangeError(`error: ${error} is not at least 0`);
  if (ratio !== undefined && faces !== undefined) throw new TypeError('ratio and faces: give one of them');
  if (ratio === undefined && faces === undefined && error === Infinity) throw new TypeError('give ratio, faces or error');
  return { ratio: ratio ?? 0, faces, error, lockBorder };
}

/**
 * Simplifies parts of one surface with one target.
 *
 * @param {Array<{indices: Uint32Array, positions: Float32Array, layers: object}>} parts three indices per triangle into the part's own
 *   vertices; positions n x 3; `layers` has arrays `normal` (n x 3), `uv` (n x 2) and `color` (n x 3) where there are any
 * @param {object} goal see `readGoal`
 * @param {{progress?: Function, signal?: AbortSignal, worker?: boolean}} control
 * @returns {Promise<Uint32Array[]>} indices of the triangles that remain of each part
 */
export async function simplifyParts(parts, goal, control) {
  const surface = joinParts(parts.map(compactPart));
  const nIndices = surface.indices.length;
  const target = 3 * Math.min(nIndices / 3, goal.faces ?? Math.floor((goal.ratio * nIndices) / 3));
  const flags = goal.lockBorder ? ['LockBorder'] : [];
  const [indices] = await simplifyIndices(surface, { target, error: goal.error, flags, ...control });
  return splitIndices(indices, surface.starts).map((chosen, i) => chosen.map((vertex) => surface.origins[i][vertex]));
}

/** A part with the vertices that its triangles use, and no others; `origins` are their numbers in the part. */
function compactPart({ indices, positions, layers }) {
  const compact = indices.slice();
  const [remap, used] = compactIndices(compact);
  const origins = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) origins[to] = from; });
  const chosen = Object.entries(layers).map(([name, array]) => [name, gatherRows(array, WEIGHTS[name][0], origins)]);
  return { indices: compact, positions: gatherRows(positions, 3, origins), layers: Object.fromEntries(chosen), origins };
}

/** Chosen rows of an array, in the order of `rows`. */
export function gatherRows(array, width, rows) {
  const gathered = new array.constructor(width * rows.length);
  for (let i = 0; i < rows.length; i++) {
    for (let j = 0; j < width; j++) gathered[width * i + j] = array[width * rows[i] + j];
  }
  return gathered;
}

/** One surface of all parts, whose vertices are those of one part behind the other. */
function joinParts(parts) {
  const names = Object.keys(WEIGHTS).filter((name) => parts.some(({ layers }) => layers[name]));
  const weights = names.flatMap((name) => new Array(WEIGHTS[name][0]).fill(WEIGHTS[name][1]));
  const starts = [0];
  for (const { origins } of parts) starts.push(starts.at(-1) + origins.length);
  const indices = new Uint32Array(parts.reduce((sum, part) => sum + part.indices.length, 0));
  const positions = new Float32Array(3 * starts.at(-1));
  const attributes = new Float32Array(weights.length * starts.at(-1));
  let at = 0;
  parts.forEach((part, i) => {
    for (const index of part.indices) indices[at++] = starts[i] + index;
    positions.set(part.positions, 3 * starts[i]);
    writeLayers(part, names, attributes.subarray(weights.length * starts[i]), weights.length);
  });
  const origins = parts.map((part) => part.origins);
  return { indices, positions, attributes, attributesStride: weights.length, weights, starts, origins };
}

/** Writes the layers of a part beside each other into rows; those that it does not have stay 0. */
function writeLayers({ layers, origins }, names, rows, stride) {
  let column = 0;
  for (const name of names) {
    const width = WEIGHTS[name][0];
    for (let i = 0; layers[name] && i < origins.length; i++) {
      for (let j = 0; j < width; j++) rows[stride * i + column + j] = layers[name][width * i + j];
    }
    column += width;
  }
}

/** The triangles of each part by the ranges of its vertices, in the part's numbers. */
function splitIndices(indices, starts) {
  const partOf = (vertex) => starts.findLastIndex((start) => start <= vertex);
  const split = starts.slice(1).map(() => []);
  for (let i = 0; i < indices.length; i += 3) {
    const part = partOf(indices[i]);
    for (let j = i; j < i + 3; j++) {
      if (indices[j] < starts[part] || indices[j] >= starts[part + 1]) throw new NeuralMeshError('a face of the result is of two parts');
      split[part].push(indices[j] - starts[part]);
    }
  }
  return split.map((list) => Uint32Array.from(list));
}

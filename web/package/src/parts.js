// Simplifies the parts of a surface together: those that different materials cover, which meet at equal positions and stay joined there.

import { compactIndices, firstEqualRows, wordsOf } from './remap.js';
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
 * @param {boolean} isShared whether all parts have the same vertices, so that a triangle may take one from another part
 * @returns {Promise<Uint32Array[]>} indices of the triangles that remain of each part
 */
export async function simplifyParts(parts, goal, control, isShared = false) {
  const compact = parts.map(compactPart);
  const surface = joinParts(compact);
  const split = splitIndices(await chosenTriangles(surface, goal, control), surface, isShared);
  if (split) return split;
  // A triangle lies across two parts. Each goes alone, with its boundary as it is: the parts stay joined and become less light.
  return Promise.all(compact.map(async (part) => {
    const alone = await chosenTriangles(joinParts([part]), aloneGoal(goal, part, surface), control);
    return alone.map((vertex) => part.origins[vertex]);
  }));
}

async function chosenTriangles(surface, { ratio, faces, error, lockBorder }, control) {
  const nIndices = surface.indices.length;
  if (nIndices === 0) return surface.indices;
  const target = 3 * Math.min(nIndices / 3, faces ?? Math.floor((ratio * nIndices) / 3));
  return (await simplifyIndices(surface, { target, error, flags: lockBorder ? ['LockBorder'] : [], ...control }))[0];
}

/** The goal of one part, with its share of the faces. */
function aloneGoal({ ratio, faces, error }, part, surface) {
  const share = part.indices.length / surface.indices.length;
  return { ratio, faces: faces === undefined ? undefined : Math.floor(faces * share), error, lockBorder: true };
}

/** A part with the vertices that its triangles use, and no others; `origins` are their numbers in the part. */
function compactPart({ indices, positions, layers }) {
  const compact = withoutDegenerate(indices, positions);
  const [remap, used] = compactIndices(compact);
  const origins = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) origins[to] = from; });
  const chosen = Object.entries(layers).map(([name, array]) => [name, gatherRows(array, WEIGHTS[name][0], origins)]);
  return { indices: compact, positions: gatherRows(positions, 3, origins), layers: Object.fromEntries(chosen), origins };
}

/** The triangles whose corners are at three positions. */
function withoutDegenerate(indices, positions) {
  const first = firstEqualRows([{ words: wordsOf(positions), width: 3 }], positions.length / 3);
  const isFace = (i) => new Set([first[indices[i]], first[indices[i + 1]], first[indices[i + 2]]]).size === 3;
  return indices.filter((_, i) => isFace(i - (i % 3)));
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

/** The triangles of each part, in the part's numbers; null where one lies across two parts that have not the same vertices. */
function splitIndices(indices, { positions, starts, origins }, isShared) {
  const { partOf, vertexIn, partOfFace } = makeSides(positions, starts);
  const originOf = (vertex) => origins[partOf(vertex)][vertex - starts[partOf(vertex)]];
  const split = origins.map(() => []);
  for (let i = 0; i < indices.length; i += 3) {
    const face = indices.subarray(i, i + 3);
    const part = partOfFace(face) ?? (isShared ? partOf(face[0]) : null);
    if (part === null) return null;
    split[part].push(...Array.from(face, (vertex) => originOf(vertexIn(part, vertex) ?? vertex)));
  }
  return split.map((list) => Uint32Array.from(list));
}

/** Finds vertices at equal positions in other parts: a triangle may come back with corners of both sides of a boundary between parts. */
function makeSides(positions, starts) {
  let first = null;
  let places = null;
  const readPlaces = () => {
    first = firstEqualRows([{ words: wordsOf(positions), width: 3 }], positions.length / 3);
    places = new Map();
    first.forEach((one, place) => (places.has(one) ? places.get(one).push(place) : places.set(one, [place])));
  };
  const partOf = (vertex) => starts.findLastIndex((start) => start <= vertex);
  const vertexIn = (part, vertex) => {
    if (vertex >= starts[part] && vertex < starts[part + 1]) return vertex;
    if (!places) readPlaces();
    return places.get(first[vertex]).find((place) => place >= starts[part] && place < starts[part + 1]);
  };
  const partOfFace = (face) => [...new Set(Array.from(face, partOf))]
    .find((part) => face.every((vertex) => vertexIn(part, vertex) !== undefined));
  return { partOf, vertexIn, partOfFace };
}

// Simplifies the parts of a surface together: those that different materials cover, which meet at equal positions and stay joined there.

import { shareOfGoal } from './goal.js';
import { compactIndices, firstEqualRows, wordsOf } from './remap.js';
import { simplifyIndices } from './simplifier.js';

/**
 * Simplifies parts of one surface with one target.
 *
 * The vertices of the surface are those of its parts, one part behind the other, without those that no triangle uses.
 *
 * @param {Array<{indices: Uint32Array, positions: Float32Array, layers: object}>} parts three indices per triangle into the part's own
 *   vertices; positions n x 3; `layers` has numbers that belong to the vertices by name: `{ array, width }`, n x width
 * @param {object} goal see `readGoal`
 * @param {{progress?: Function, signal?: AbortSignal, worker?: boolean}} control
 * @param {boolean} isShared whether all parts have the same vertices, so that a triangle may take one from another part
 * @returns {Promise<{triangles: Uint32Array[], origins: Uint32Array, moved: object | null}>} the triangles that remain of each part, in
 *   vertices of the surface; the part's own number of each of these; `positions` and `layers` of all of them where they moved
 */
export async function simplifyParts(parts, goal, control, isShared = false) {
  const compact = parts.map(compactPart);
  const surface = joinParts(compact);
  const chosen = await simplifySurface(surface, goal, control);
  const split = splitTriangles(chosen, surface, isShared);
  if (split) return { triangles: split, origins: surface.origins, moved: chosen.moved };
  // A triangle lies across two parts. Vertices that stay can be found on both sides of a boundary.
  if (goal.move) return simplifyParts(parts, { ...goal, move: false }, control);
  // Else each part goes alone, with its boundary as it is: the parts stay joined and become less light.
  const triangles = await Promise.all(compact.map(async (part, i) => {
    const alone = joinParts([part]);
    const { indices } = await simplifySurface(alone, shareOfGoal(goal, alone.indices.length / surface.indices.length), control);
    return indices.map((vertex) => surface.starts[i] + vertex);
  }));
  return { triangles, origins: surface.origins, moved: null };
}

async function simplifySurface({ layers, ...surface }, { ratio, faces, error, lockBorder, move }, control) {
  const nIndices = surface.indices.length;
  if (nIndices === 0) return { indices: surface.indices, moved: null };
  const target = 3 * Math.min(nIndices / 3, faces ?? Math.floor((ratio * nIndices) / 3));
  const rows = move ? rowsOfLayers(layers, surface.positions.length / 3) : {};
  const flags = lockBorder ? ['LockBorder'] : [];
  const { indices, positions, attributes } = await simplifyIndices({ ...surface, ...rows }, { target, error, flags, move, ...control });
  return { indices, moved: move ? { positions, layers: layersOfRows(layers, attributes) } : null };
}

/** A part with the vertices that its triangles use, and no others; `origins` are their numbers in the part. */
function compactPart({ indices, positions, layers }) {
  const compact = withoutDegenerate(indices, positions);
  const origins = usedVertices(compact);
  const chosen = Object.entries(layers).map(([name, { array, width }]) => [name, { array: gatherRows(array, width, origins), width }]);
  return { indices: compact, positions: gatherRows(positions, 3, origins), layers: Object.fromEntries(chosen), origins };
}

/** The triangles whose corners are at three positions. */
function withoutDegenerate(indices, positions) {
  const first = firstEqualRows([{ words: wordsOf(positions), width: 3 }], positions.length / 3);
  const isFace = (i) => new Set([first[indices[i]], first[indices[i + 1]], first[indices[i + 2]]]).size === 3;
  return indices.filter((_, i) => isFace(i - (i % 3)));
}

/** Numbers vertices in the order of their use, writes these numbers into `indices`, and returns the old number of each. */
export function usedVertices(indices) {
  const [remap, used] = compactIndices(indices);
  const origins = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) origins[to] = from; });
  return origins;
}

/** Chosen rows of an array, in the order of `rows`. */
export function gatherRows(array, width, rows) {
  const gathered = new array.constructor(width * rows.length);
  for (let i = 0; i < rows.length; i++) {
    for (let j = 0; j < width; j++) gathered[width * i + j] = array[width * rows[i] + j];
  }
  return gathered;
}

/** One surface of all parts. A layer that a part does not have is 0 there. */
function joinParts(parts) {
  const starts = [0];
  for (const { origins } of parts) starts.push(starts.at(-1) + origins.length);
  const n = starts.at(-1);
  const joined = (width, arrayOf) => {
    const array = new Float32Array(width * n);
    parts.forEach((part, i) => array.set(arrayOf(part) ?? [], width * starts[i]));
    return array;
  };
  const widths = Object.assign({}, ...parts.map(({ layers }) => layers));
  const layers = Object.entries(widths).map(([name, { width }]) =>
    [name, { array: joined(width, (part) => part.layers[name]?.array), width }]);
  const indices = Uint32Array.from(parts.flatMap((part, i) => Array.from(part.indices, (index) => starts[i] + index)));
  const origins = Uint32Array.from(parts.flatMap((part) => Array.from(part.origins)));
  return { indices, positions: joined(3, (part) => part.positions), layers: Object.fromEntries(layers), starts, origins };
}

/** Layers beside each other in rows, one for each vertex. They do not count: seams between them stay anyway. */
function rowsOfLayers(layers, nVertices) {
  const stride = Object.values(layers).reduce((sum, { width }) => sum + width, 0);
  const attributes = new Float32Array(stride * nVertices);
  let column = 0;
  for (const { array, width } of Object.values(layers)) {
    for (let i = 0; i < nVertices; i++) {
      for (let j = 0; j < width; j++) attributes[stride * i + column + j] = array[width * i + j];
    }
    column += width;
  }
  return { attributes, attributesStride: stride, weights: new Array(stride).fill(0) };
}

/** The arrays of layers out of rows. */
function layersOfRows(layers, attributes = new Float32Array(0)) {
  const stride = Object.values(layers).reduce((sum, { width }) => sum + width, 0);
  let column = 0;
  return Object.fromEntries(Object.entries(layers).map(([name, { width }]) => {
    const from = column;
    column += width;
    const array = Float32Array.from({ length: (attributes.length / stride) * width || 0 }, (_, i) =>
      attributes[stride * Math.floor(i / width) + from + (i % width)]);
    return [name, array];
  }));
}

/** The triangles of each part; null where one lies across two parts that have not the same vertices. */
function splitTriangles({ indices, moved }, { positions, starts }, isShared) {
  const { partOf, vertexIn, partOfFace } = makeSides(positions, starts, moved !== null);
  const split = starts.slice(1).map(() => []);
  for (let i = 0; i < indices.length; i += 3) {
    const face = indices.subarray(i, i + 3);
    const part = partOfFace(face) ?? (isShared ? partOf(face[0]) : null);
    if (part === null) return null;
    split[part].push(...Array.from(face, (vertex) => vertexIn(part, vertex) ?? vertex));
  }
  return split.map((list) => Uint32Array.from(list));
}

/** Finds vertices at equal positions in other parts: a triangle may come back with corners of both sides of a boundary between parts. */
function makeSides(positions, starts, hasMoved) {
  let first = null;
  let places = null;
  const readPlaces = () => {
    first = firstEqualRows([{ words: wordsOf(positions), width: 3 }], positions.length / 3);
    places = new Map();
    first.forEach((one, place) => (places.has(one) ? places.get(one).push(place) : places.set(one, [place])));
  };
  const partOf = (vertex) => starts.findLastIndex((start) => start <= vertex);
  const vertexIn = (part, vertex) => {
    const isIn = (place) => place >= starts[part] && place < starts[part + 1];
    if (isIn(vertex)) return vertex;
    if (hasMoved) return undefined;
    if (!places) readPlaces();
    return places.get(first[vertex]).find(isIn);
  };
  const partOfFace = (face) => [...new Set(Array.from(face, partOf))]
    .find((part) => face.every((vertex) => vertexIn(part, vertex) !== undefined));
  return { partOf, vertexIn, partOfFace };
}

// Simplifies the parts of a surface together. A part has the triangles of one material; parts stay joined at equal positions.

import { separateParts } from './corners.js';
import { compactIndices, firstEqualRows, wordsOf } from './remap.js';
import { simplifyIndices } from './simplifier.js';

/**
 * Simplifies the parts of one surface to one size.
 *
 * The vertices of the surface are the used vertices of its parts, in the order of the parts.
 *
 * @param {Array<{indices: Uint32Array, positions: Float32Array, layers: object}>} parts three indices per triangle into the part's own
 *   vertices; positions n x 3; `layers` has vertex attributes by name as `{ array, width }`, n x width; names of morph targets contain
 *   a space
 * @param {object} goal see `readGoal`
 * @param {{progress?: Function, signal?: AbortSignal, worker?: boolean}} control
 * @returns {Promise<{triangles: Uint32Array[], origins: Uint32Array, owners: Uint32Array, looks: Uint32Array, moved: object | null}>} the
 *   triangles of each part, in vertices of the surface; for each vertex, the part that its position is from, its number there, and the
 *   number of the vertex that its other attributes are from, in the part of its triangles; new `positions` and `layers` if vertices moved
 */
export async function simplifyParts(parts, goal, control) {
  const surface = joinParts(parts.map(compactPart));
  const { origins, owners, starts } = surface;
  const chosen = await simplifySurface(surface, goal, control);
  const { indices, sources, looks } = separateParts(chosen, chosen.moved?.positions ?? surface.positions, starts);
  return {
    triangles: splitTriangles(indices, chosen.groups, parts.length),
    origins: gatherRows(origins, 1, sources), owners: gatherRows(owners, 1, sources), looks: gatherRows(origins, 1, looks),
    moved: chosen.moved && gatherMoved(chosen.moved, surface.layers, sources, looks),
  };
}

/** Gathers moved values for vertices and copies; morph targets follow the position, other layers the look. */
function gatherMoved({ positions, layers }, inputLayers, sources, looks) {
  const gathered = Object.entries(layers).map(([name, array]) =>
    [name, gatherRows(array, inputLayers[name].width, name.includes(' ') ? sources : looks)]);
  return { positions: gatherRows(positions, 3, sources), layers: Object.fromEntries(gathered) };
}

async function simplifySurface({ indices, positions, groups, layers }, { ratio, faces, error, lockBorder, move }, control) {
  const nIndices = indices.length;
  if (nIndices === 0) return { indices, groups, moved: null };
  const target = 3 * Math.min(nIndices / 3, faces ?? Math.floor((ratio * nIndices) / 3));
  const surface = { indices, positions, groups, ...(move && rowsOfLayers(layers, positions.length / 3)) };
  const flags = lockBorder ? ['LockBorder'] : [];
  const chosen = await simplifyIndices(surface, { target, error, flags, move, ...control });
  const moved = move ? { positions: chosen.positions, layers: layersOfRows(layers, chosen.attributes) } : null;
  return { indices: chosen.indices, groups: chosen.groups, moved };
}

/** Returns a part without unused vertices and degenerate triangles; `origins` are the old numbers of its vertices. */
function compactPart({ indices, positions, layers }) {
  const compact = withoutDegenerate(indices, positions);
  const origins = usedVertices(compact);
  const chosen = Object.entries(layers).map(([name, { array, width }]) => [name, { array: gatherRows(array, width, origins), width }]);
  return { indices: compact, positions: gatherRows(positions, 3, origins), layers: Object.fromEntries(chosen), origins };
}

/** Returns the triangles whose corners are at three different positions. */
function withoutDegenerate(indices, positions) {
  const first = firstEqualRows([{ words: wordsOf(positions), width: 3 }], positions.length / 3);
  const isFace = (i) => new Set([first[indices[i]], first[indices[i + 1]], first[indices[i + 2]]]).size === 3;
  return indices.filter((_, i) => isFace(i - (i % 3)));
}

/** Renumbers vertices in the order of their first use, updates `indices`, and returns the old number of each vertex. */
export function usedVertices(indices) {
  const [remap, used] = compactIndices(indices);
  const origins = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) origins[to] = from; });
  return origins;
}

/** Returns the given rows of an array, in the order of `rows`. */
export function gatherRows(array, width, rows) {
  const gathered = new array.constructor(width * rows.length);
  for (let i = 0; i < rows.length; i++) {
    for (let j = 0; j < width; j++) gathered[width * i + j] = array[width * rows[i] + j];
  }
  return gathered;
}

/** Joins all parts into one surface, each a group with its own vertices. Layers that a part lacks are 0 there. */
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
  const groups = Uint32Array.from(parts.flatMap((part, i) => new Array(part.indices.length / 3).fill(i)));
  const origins = Uint32Array.from(parts.flatMap((part) => Array.from(part.origins)));
  const owners = Uint32Array.from(parts.flatMap((part, i) => new Array(part.origins.length).fill(i)));
  const positions = joined(3, (part) => part.positions);
  return { indices, groups, positions, layers: Object.fromEntries(layers), origins, owners, starts };
}

/** Packs layers into one row per vertex, with weights 0: they are carried only, and seams between parts stay anyway. */
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

/** Unpacks rows into one array per layer. */
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

/** Splits triangles by part. */
function splitTriangles(indices, groups, nParts) {
  const split = Array.from({ length: nParts }, () => []);
  groups.forEach((part, face) => split[part].push(...indices.subarray(3 * face, 3 * face + 3)));
  return split.map((list) => Uint32Array.from(list));
}

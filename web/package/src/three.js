// A modifier for three.js: a lighter geometry of a geometry, with all that its vertices carry.

import { BufferAttribute, BufferGeometry } from 'three';

import { firstEqualRows, compactIndices, wordsOf } from './remap.js';
import { gatherRows, readGoal, simplifyParts } from './parts.js';

/** Makes a lighter geometry. `types/three.d.ts` documents it. */
export async function simplifyModifier(geometry, options = {}) {
  checkGeometry(geometry);
  const goal = readGoal(options);
  const columns = allAttributes(geometry).map((attribute) => ({ words: wordsOf(rawRows(attribute)), width: attribute.itemSize }));
  const first = firstEqualRows(columns, geometry.attributes.position.count);
  const segments = segmentsOf(geometry, readIndices(geometry).map((vertex) => first[vertex]));
  const surface = { positions: readNumbers(geometry.attributes.position, 3), layers: readLayers(geometry) };
  const parts = segments.map(({ indices }) => ({ indices, ...surface }));
  const { progress, signal, worker } = options;
  return geometryOf(geometry, segments, await simplifyParts(parts, goal, { progress, signal, worker }, true));
}

function checkGeometry(geometry) {
  if (!geometry?.isBufferGeometry) throw new TypeError('geometry: give a BufferGeometry');
  if (!geometry.attributes.position) throw new TypeError('geometry: it has no attribute "position"');
  if (geometry.isInstancedBufferGeometry) throw new TypeError('geometry: give a BufferGeometry that is drawn once');
}

/** Attributes and those of morph targets, which all have a row per vertex. */
function allAttributes({ attributes, morphAttributes }) {
  return [...Object.values(attributes), ...Object.values(morphAttributes).flat()];
}

function readIndices({ index, attributes }) {
  if (index) return Uint32Array.from(index.array);
  return Uint32Array.from({ length: attributes.position.count - (attributes.position.count % 3) }, (_, i) => i);
}

/** The stored numbers of an attribute, one row behind the other, in their own class of arrays. */
function rawRows(attribute) {
  if (!attribute.isInterleavedBufferAttribute) return attribute.array;
  const { data, offset, itemSize, count } = attribute;
  const rows = new data.array.constructor(itemSize * count);
  for (let i = 0; i < count; i++) {
    for (let j = 0; j < itemSize; j++) rows[itemSize * i + j] = data.array[data.stride * i + offset + j];
  }
  return rows;
}

/** The first `width` numbers of each row as they mean, zero where there are fewer. */
function readNumbers(attribute, width) {
  const numbers = new Float32Array(width * attribute.count);
  for (let i = 0; i < attribute.count; i++) {
    for (let j = 0; j < Math.min(width, attribute.itemSize); j++) numbers[width * i + j] = attribute.getComponent(i, j);
  }
  return numbers;
}

function readLayers({ attributes: { normal, uv, color } }) {
  return {
    ...(normal && { normal: readNumbers(normal, 3) }),
    ...(uv && { uv: readNumbers(uv, 2) }),
    ...(color && { color: readNumbers(color, 3) }),
  };
}

/** Runs of triangles that lie in one set of groups; groups may leave triangles out, and lie over each other. */
function segmentsOf({ groups }, indices) {
  const end = indices.length - (indices.length % 3);
  const clip = (at) => Math.min(at, end);
  const ranges = groups.map(({ start, count, materialIndex }) => ({ from: clip(start), to: clip(start + count), materialIndex }));
  const cuts = [...new Set([0, end, ...ranges.flatMap(({ from, to }) => [from, to])])].sort((a, b) => a - b);
  return cuts.slice(1).map((to, i) => {
    const from = cuts[i];
    const inside = ranges.flatMap((range, group) => (range.from <= from && to <= range.to ? [group] : []));
    return { indices: indices.slice(from, to), groups: inside };
  });
}

/** A geometry of the vertices in use, its triangles in the order of segments. */
function geometryOf(source, segments, chosen) {
  const indices = new Uint32Array(chosen.reduce((sum, part) => sum + part.length, 0));
  const starts = chosen.map((part, i) => chosen.slice(0, i).reduce((sum, { length }) => sum + length, 0));
  chosen.forEach((part, i) => indices.set(part, starts[i]));
  const [remap, used] = compactIndices(indices);
  const rows = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) rows[to] = from; });
  const geometry = new BufferGeometry();
  geometry.name = source.name;
  geometry.userData = structuredClone(source.userData);
  geometry.morphTargetsRelative = source.morphTargetsRelative;
  geometry.setIndex(new BufferAttribute(used > 0xffff ? indices : Uint16Array.from(indices), 1));
  for (const [name, attribute] of Object.entries(source.attributes)) geometry.setAttribute(name, chosenRows(attribute, rows));
  for (const [name, list] of Object.entries(source.morphAttributes)) {
    geometry.morphAttributes[name] = list.map((attribute) => chosenRows(attribute, rows));
  }
  source.groups.forEach(({ materialIndex }, group) => {
    for (const [start, count] of rangesOf(group, segments, chosen, starts)) geometry.addGroup(start, count, materialIndex);
  });
  return geometry;
}

function chosenRows(attribute, rows) {
  const chosen = new BufferAttribute(gatherRows(rawRows(attribute), attribute.itemSize, rows), attribute.itemSize, attribute.normalized);
  chosen.name = attribute.name;
  if (attribute.gpuType !== undefined) chosen.gpuType = attribute.gpuType;
  return chosen;
}

/** Start and count of a group in the result: its segments follow each other. */
function rangesOf(group, segments, chosen, starts) {
  const inside = segments.flatMap((segment, i) => (segment.groups.includes(group) ? [i] : []));
  if (inside.length === 0) return [];
  return [[starts[inside[0]], inside.reduce((sum, i) => sum + chosen[i].length, 0)]];
}

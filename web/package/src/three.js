// Simplifies geometries of three.js with all vertex attributes.

import { BufferAttribute, BufferGeometry } from 'three';

import { readGoal } from './goal.js';
import { gatherRows, simplifyParts, usedVertices } from './parts.js';
import { firstEqualRows, wordsOf } from './remap.js';
import { normalizeRows, storeNumbers } from './store.js';

/** Attributes that are interpolated over the surface; others come from the closest vertex. */
const SMOOTH = /^(normal|tangent|uv\d?|color)$/;
const GETTERS = ['getX', 'getY', 'getZ', 'getW'];

/** Simplifies a geometry; see `types/three.d.ts`. */
export async function simplifyModifier(geometry, options = {}) {
  checkGeometry(geometry);
  const goal = readGoal(options);
  const first = firstEqual(geometry);
  const segments = segmentsOf(geometry, readIndices(geometry).map((vertex) => first[vertex]));
  const surface = { positions: readNumbers(geometry.attributes.position, 3), layers: readLayers(geometry) };
  const parts = segments.map(({ indices }) => ({ indices, ...surface }));
  const { progress, signal, worker } = options;
  return geometryOf(geometry, segments, await simplifyParts(parts, goal, { progress, signal, worker }));
}

function checkGeometry(geometry) {
  if (!geometry?.isBufferGeometry) throw new TypeError('geometry: give a BufferGeometry');
  if (!geometry.attributes.position) throw new TypeError('geometry: it has no attribute "position"');
  if (geometry.isInstancedBufferGeometry) throw new TypeError('geometry: give a BufferGeometry without instancing');
}

/** Finds for each vertex the first one that is equal in all attributes and morph targets. */
function firstEqual(geometry) {
  const column = ([, attribute]) => ({ words: wordsOf(rawRows(attribute)), width: attribute.itemSize });
  const columns = [...namedAttributes(geometry)].map(column);
  return firstEqualRows(columns, geometry.attributes.position.count);
}

/** Yields attributes by name, and those of morph targets by name and number. */
function* namedAttributes({ attributes, morphAttributes }) {
  yield* Object.entries(attributes);
  for (const [name, list] of Object.entries(morphAttributes)) {
    for (const [i, attribute] of list.entries()) yield [`${name} ${i}`, attribute];
  }
}

function readIndices({ index, attributes }) {
  if (index) return Uint32Array.from(index.array);
  return Uint32Array.from({ length: attributes.position.count - (attributes.position.count % 3) }, (_, i) => i);
}

/** Returns the stored numbers of an attribute as packed rows in their own class of arrays. */
function rawRows(attribute) {
  if (!attribute.isInterleavedBufferAttribute) return attribute.array;
  const { data, offset, itemSize, count } = attribute;
  const rows = new data.array.constructor(itemSize * count);
  for (let i = 0; i < count; i++) {
    for (let j = 0; j < itemSize; j++) rows[itemSize * i + j] = data.array[data.stride * i + offset + j];
  }
  return rows;
}

/** Returns the first `width` numbers of each row as floats; normalized integers are decoded. */
function readNumbers(attribute, width = attribute.itemSize) {
  const numbers = new Float32Array(width * attribute.count);
  for (let j = 0; j < width; j++) {
    for (let i = 0; i < attribute.count; i++) numbers[width * i + j] = attribute[GETTERS[j]](i);
  }
  return numbers;
}

/** Reads the attributes that change when vertices move: smooth ones, and morph targets as differences to their base. */
function readLayers(geometry) {
  const layers = {};
  for (const [name, attribute] of namedAttributes(geometry)) {
    const [base, isTarget] = [name.split(' ')[0], name.includes(' ')];
    if (base !== name ? attribute.itemSize > 4 : !SMOOTH.test(name)) continue;
    const array = readNumbers(attribute);
    if (isTarget && !geometry.morphTargetsRelative) addRows(array, readNumbers(geometry.attributes[base], attribute.itemSize), -1);
    layers[name] = { array, width: attribute.itemSize };
  }
  return layers;
}

function addRows(array, other, factor) {
  for (let i = 0; i < array.length; i++) array[i] += factor * other[i];
}

/** Splits triangles into runs that belong to one set of groups, as groups may overlap and leave triangles out. */
function segmentsOf({ groups }, indices) {
  const end = indices.length - (indices.length % 3);
  const clip = (at) => Math.min(at, end);
  const ranges = groups.map(({ start, count }) => ({ from: clip(start), to: clip(start + count) }));
  const cuts = [...new Set([0, end, ...ranges.flatMap(({ from, to }) => [from, to])])].sort((a, b) => a - b);
  return cuts.slice(1).map((to, i) => {
    const from = cuts[i];
    const inside = ranges.flatMap((range, group) => (range.from <= from && to <= range.to ? [group] : []));
    return { indices: indices.slice(from, to), groups: inside };
  });
}

/** Creates a geometry of the used vertices, with triangles in the order of the segments. */
function geometryOf(source, segments, { triangles, origins, looks, moved }) {
  const indices = Uint32Array.from(triangles.flatMap((part) => Array.from(part)));
  const used = usedVertices(indices);
  const rowsOf = makeRows(source, used, { origins: gatherRows(origins, 1, used), looks: gatherRows(looks, 1, used) }, moved);
  const geometry = new BufferGeometry();
  geometry.name = source.name;
  geometry.userData = structuredClone(source.userData);
  geometry.morphTargetsRelative = source.morphTargetsRelative;
  for (const [name, attribute] of Object.entries(source.attributes)) geometry.setAttribute(name, rowsOf(name, attribute));
  for (const [name, list] of Object.entries(source.morphAttributes)) {
    geometry.morphAttributes[name] = list.map((attribute, i) => rowsOf(`${name} ${i}`, attribute));
  }
  joinEqual(geometry, indices);
  addGroups(geometry, source, segments, triangles);
  return geometry;
}

/** Returns a function that creates the result's attribute for an attribute of the source. */
function makeRows(source, used, { origins, looks }, moved) {
  const named = { ...moved?.layers, ...(moved && { position: moved.positions }) };
  return (name, attribute) => {
    const { itemSize, normalized } = attribute;
    if (!named[name]) return attributeOf(gatherRows(rawRows(attribute), itemSize, SMOOTH.test(name) ? looks : origins), attribute);
    const [base, target] = name.split(' ');
    const values = gatherRows(named[name], itemSize, used);
    if (target && !source.morphTargetsRelative) addRows(values, gatherRows(named[base], itemSize, used), 1);
    if (!target && /^(normal|tangent)$/.test(name)) normalizeRows(values, itemSize);
    // three.js stores half precision in an integer array, so the values are written in single precision.
    const type = attribute.isFloat16BufferAttribute ? Float32Array : rawRows(attribute).constructor;
    return attributeOf(storeNumbers(values, type, normalized), attribute);
  };
}

function attributeOf(array, { itemSize, normalized, name, gpuType }) {
  const attribute = new BufferAttribute(array, itemSize, normalized);
  attribute.name = name;
  if (gpuType !== undefined) attribute.gpuType = gpuType;
  return attribute;
}

/** Merges vertices that are equal in all attributes, such as those at borders between groups, and sets the index. */
function joinEqual(geometry, indices) {
  const first = firstEqual(geometry);
  const joined = indices.map((vertex) => first[vertex]);
  const rows = usedVertices(joined);
  const chosen = (attribute) => attributeOf(gatherRows(attribute.array, attribute.itemSize, rows), attribute);
  for (const [name, attribute] of Object.entries(geometry.attributes)) geometry.setAttribute(name, chosen(attribute));
  for (const [name, list] of Object.entries(geometry.morphAttributes)) geometry.morphAttributes[name] = list.map(chosen);
  geometry.setIndex(new BufferAttribute(rows.length > 0xffff ? joined : Uint16Array.from(joined), 1));
}

/** Adds the groups of the source; the segments of a group are consecutive. */
function addGroups(geometry, source, segments, triangles) {
  const starts = triangles.map((_, i) => triangles.slice(0, i).reduce((sum, { length }) => sum + length, 0));
  source.groups.forEach(({ materialIndex }, group) => {
    const inside = segments.flatMap((segment, i) => (segment.groups.includes(group) ? [i] : []));
    const count = inside.reduce((sum, i) => sum + triangles[i].length, 0);
    if (count > 0) geometry.addGroup(starts[inside[0]], count, materialIndex);
  });
}

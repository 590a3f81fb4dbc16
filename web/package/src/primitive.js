// Primitives of glTF-Transform: their triangles and what these carry, read, and cut down to what remains.

import { gatherRows, usedVertices } from './parts.js';
import { firstEqualRows, wordsOf } from './remap.js';
import { normalizeRows, storeNumbers } from './store.js';

const [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN] = [4, 5, 6];
/** Attributes that run on evenly over the surface; others are those of the nearest vertex. */
const SMOOTH = /^(NORMAL|TANGENT|TEXCOORD_\d+|COLOR_\d+)$/;

/** Whether a primitive is of triangles. */
export function isOfTriangles(primitive) {
  return [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN].includes(primitive.getMode()) && primitive.getAttribute('POSITION') !== null;
}

/** A primitive as a part of a surface, vertices that are equal in all attributes and morph targets as one. */
export function readPart(primitive) {
  const position = primitive.getAttribute('POSITION');
  const accessors = [...namedAccessors(primitive)];
  const columns = accessors.map(([, accessor]) => ({ words: wordsOf(accessor.getArray()), width: accessor.getElementSize() }));
  const first = firstEqualRows(columns, position.getCount());
  const smooth = accessors.filter(([name]) => name.includes(' ') || SMOOTH.test(name));
  const layers = smooth.map(([name, accessor]) => [name, { array: readNumbers(accessor), width: accessor.getElementSize() }]);
  const indices = trianglesOf(primitive, position.getCount()).map((vertex) => first[vertex]);
  return { primitive, indices, positions: readNumbers(position), layers: Object.fromEntries(layers) };
}

/**
 * Makes the accessors of what remains of a part; changes nothing that is there.
 *
 * @param {object[]} parts of a surface
 * @param {number} number that of the part
 * @param {object} chosen as `simplifyParts` returns it
 * @returns {{indices: TypedArray, lighter: Map}} `lighter` has the new accessor of each old one
 */
export function lightenPart(document, parts, number, { triangles, origins, owners, looks, moved }) {
  const indices = triangles[number];
  if (indices.length === 0) return { indices, lighter: new Map() };
  const used = usedVertices(indices);
  const rows = { used, looks: gatherRows(looks, 1, used), named: { ...moved?.layers, ...(moved && { POSITION: moved.positions }) } };
  const copies = Array.from(used.keys()).filter((i) => owners[used[i]] !== number);
  // Accessors that attributes of this primitive share stay shared.
  const lighter = new Map();
  for (const [name, accessor] of namedAccessors(parts[number].primitive)) {
    if (lighter.has(accessor)) continue;
    const light = lighterAccessor(document, accessor, name, rows);
    lighter.set(accessor, light);
    if (rows.named[name] || SMOOTH.test(name)) continue;
    // What is no look comes with a copy from where it is, as far as it is there.
    for (const i of copies) {
      const there = new Map(namedAccessors(parts[owners[used[i]]].primitive)).get(name);
      if (there?.getElementSize() === light.getElementSize()) light.setElement(i, there.getElement(origins[used[i]], []));
    }
  }
  return { indices: used.length > 0xffff ? indices : Uint16Array.from(indices), lighter };
}

/** Sets what `lightenPart` made; without triangles a primitive leaves its mesh. Accessors that others use as well stay as they are. */
export function writePart(document, mesh, primitive, { indices, lighter }) {
  if (indices.length === 0) return dropPrimitive(mesh, primitive);
  writeIndices(document, primitive, indices);
  for (const owner of [primitive, ...primitive.listTargets()]) {
    for (const semantic of owner.listSemantics()) owner.setAttribute(semantic, lighter.get(owner.getAttribute(semantic)));
  }
  [...lighter.keys()].forEach(disposeUnused);
}

/** Attributes by name, and those of morph targets by name and number. */
function* namedAccessors(primitive) {
  for (const semantic of primitive.listSemantics()) yield [semantic, primitive.getAttribute(semantic)];
  for (const [i, target] of primitive.listTargets().entries()) {
    for (const semantic of target.listSemantics()) yield [`${semantic} ${i}`, target.getAttribute(semantic)];
  }
}

/** Three indices per triangle, in a list whatever the mode is. */
function trianglesOf(primitive, nVertices) {
  const stored = primitive.getIndices()?.getArray() ?? Uint32Array.from({ length: nVertices }, (_, i) => i);
  const nTriangles = Math.max(0, stored.length - 2);
  if (primitive.getMode() === TRIANGLES) return Uint32Array.from(stored.subarray(0, stored.length - (stored.length % 3)));
  const triangles = new Uint32Array(3 * nTriangles);
  const isFan = primitive.getMode() === TRIANGLE_FAN;
  // Every second triangle of a strip runs the other way round.
  for (let i = 0; i < nTriangles; i++) {
    const corners = isFan ? [i + 1, i + 2, 0] : [i, i + 1 + (i % 2), i + 2 - (i % 2)];
    triangles.set(corners.map((corner) => stored[corner]), 3 * i);
  }
  return triangles;
}

/** The numbers of each element as they mean. */
function readNumbers(accessor) {
  const width = accessor.getElementSize();
  const numbers = new Float32Array(width * accessor.getCount());
  const element = [];
  for (let i = 0; i < accessor.getCount(); i++) {
    accessor.getElement(i, element);
    for (let j = 0; j < width; j++) numbers[width * i + j] = element[j];
  }
  return numbers;
}

/** An accessor of the vertices in use, else as the old one. */
function lighterAccessor(document, accessor, name, { named, used, looks }) {
  const [width, type] = [accessor.getElementSize(), accessor.getArray().constructor];
  let array = named[name] ? gatherRows(named[name], width, used) : gatherRows(accessor.getArray(), width, looks);
  if (named[name] && /^(NORMAL|TANGENT)$/.test(name)) normalizeRows(array, width);
  if (named[name]) array = storeNumbers(array, type, accessor.getNormalized());
  return document.createAccessor(accessor.getName(), accessor.getBuffer())
    .setType(accessor.getType()).setArray(array).setNormalized(accessor.getNormalized()).setSparse(accessor.getSparse())
    .setExtras(accessor.getExtras());
}

function writeIndices(document, primitive, indices) {
  const old = primitive.getIndices();
  const buffer = old?.getBuffer() ?? primitive.getAttribute('POSITION').getBuffer();
  primitive.setIndices(document.createAccessor(old?.getName() ?? '', buffer).setType('SCALAR').setArray(indices));
  primitive.setMode(TRIANGLES);
  if (old) disposeUnused(old);
}

function dropPrimitive(mesh, primitive) {
  const owners = [primitive, ...primitive.listTargets()];
  const accessors = [...namedAccessors(primitive)].map(([, accessor]) => accessor);
  if (primitive.getIndices()) accessors.push(primitive.getIndices());
  mesh.removePrimitive(primitive);
  owners.forEach((owner) => owner.dispose());
  new Set(accessors).forEach(disposeUnused);
}

/** Ends an accessor that only the document's list names. */
function disposeUnused(accessor) {
  if (accessor.listParents().every(({ propertyType }) => propertyType === 'Root')) accessor.dispose();
}

// Reads primitives of glTF-Transform with their attributes, and writes the simplified ones.

import { gatherRows, usedVertices } from './parts.js';
import { firstEqualRows, wordsOf } from './remap.js';
import { normalizeRows, storeNumbers } from './store.js';

const [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN] = [4, 5, 6];
/** Attributes that are interpolated over the surface; others come from the closest vertex. */
const SMOOTH = /^(NORMAL|TANGENT|TEXCOORD_\d+|COLOR_\d+)$/;

/** Returns whether a primitive consists of triangles. */
export function isOfTriangles(primitive) {
  return [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN].includes(primitive.getMode()) && primitive.getAttribute('POSITION') !== null;
}

/** Reads a primitive as a part of a surface; vertices equal in all attributes and morph targets are merged. */
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
 * Creates the accessors of a simplified part without changing existing ones.
 *
 * @param {object[]} parts all parts of the surface
 * @param {number} number index of the part
 * @param {object} chosen result of `simplifyParts`
 * @returns {{indices: TypedArray, lighter: Map}} `lighter` maps each old accessor to the new one
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
    // For a copied vertex, attributes such as joints come from the vertex at its position, if that part has them.
    for (const i of copies) {
      const there = new Map(namedAccessors(parts[owners[used[i]]].primitive)).get(name);
      if (there?.getElementSize() === light.getElementSize()) light.setElement(i, there.getElement(origins[used[i]], []));
    }
  }
  return { indices: used.length > 0xffff ? indices : Uint16Array.from(indices), lighter };
}

/** Sets the accessors of `lightenPart`, or removes a primitive without triangles. Accessors used elsewhere stay unchanged. */
export function writePart(document, mesh, primitive, { indices, lighter }) {
  if (indices.length === 0) return dropPrimitive(mesh, primitive);
  writeIndices(document, primitive, indices);
  for (const owner of [primitive, ...primitive.listTargets()]) {
    for (const semantic of owner.listSemantics()) owner.setAttribute(semantic, lighter.get(owner.getAttribute(semantic)));
  }
  [...lighter.keys()].forEach(disposeUnused);
}

/** Yields attributes by name, and those of morph targets by name and number. */
function* namedAccessors(primitive) {
  for (const semantic of primitive.listSemantics()) yield [semantic, primitive.getAttribute(semantic)];
  for (const [i, target] of primitive.listTargets().entries()) {
    for (const semantic of target.listSemantics()) yield [`${semantic} ${i}`, target.getAttribute(semantic)];
  }
}

/** Returns three indices per triangle, for lists, strips and fans. */
function trianglesOf(primitive, nVertices) {
  const stored = primitive.getIndices()?.getArray() ?? Uint32Array.from({ length: nVertices }, (_, i) => i);
  const nTriangles = Math.max(0, stored.length - 2);
  if (primitive.getMode() === TRIANGLES) return Uint32Array.from(stored.subarray(0, stored.length - (stored.length % 3)));
  const triangles = new Uint32Array(3 * nTriangles);
  const isFan = primitive.getMode() === TRIANGLE_FAN;
  // Every second triangle of a strip has the opposite winding.
  for (let i = 0; i < nTriangles; i++) {
    const corners = isFan ? [i + 1, i + 2, 0] : [i, i + 1 + (i % 2), i + 2 - (i % 2)];
    triangles.set(corners.map((corner) => stored[corner]), 3 * i);
  }
  return triangles;
}

/** Returns the elements of an accessor as floats; normalized integers are decoded. */
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

/** Creates an accessor for the used vertices with the properties of the old one. */
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

/** Disposes of an accessor that nothing but the document's root refers to. */
function disposeUnused(accessor) {
  if (accessor.listParents().every(({ propertyType }) => propertyType === 'Root')) accessor.dispose();
}

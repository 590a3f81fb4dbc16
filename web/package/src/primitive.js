// Primitives of glTF-Transform: their triangles and what these carry, read, and cut down to what remains.

import { gatherRows } from './parts.js';
import { compactIndices, firstEqualRows, wordsOf } from './remap.js';

const [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN] = [4, 5, 6];

/** Whether a primitive is of triangles. */
export function triangleModes(primitive) {
  return [TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN].includes(primitive.getMode()) && primitive.getAttribute('POSITION') !== null;
}

/** A primitive as a part of a surface, vertices that are equal in all attributes and morph targets as one. */
export function readPart(primitive) {
  const position = primitive.getAttribute('POSITION');
  const columns = allAccessors(primitive).map((accessor) => ({ words: wordsOf(accessor.getArray()), width: accessor.getElementSize() }));
  const first = firstEqualRows(columns, position.getCount());
  const layers = {};
  for (const [layer, semantic, width] of [['normal', 'NORMAL', 3], ['uv', 'TEXCOORD_0', 2], ['color', 'COLOR_0', 3]]) {
    const accessor = primitive.getAttribute(semantic);
    if (accessor) layers[layer] = readNumbers(accessor, width);
  }
  const indices = trianglesOf(primitive, position.getCount()).map((vertex) => first[vertex]);
  return { primitive, indices, positions: readNumbers(position, 3), layers };
}

/** Sets the triangles of a primitive and drops the vertices that none uses; without triangles it leaves its mesh. */
export function writePart(document, mesh, primitive, indices) {
  if (indices.length === 0) return dropPrimitive(mesh, primitive);
  const [remap, used] = compactIndices(indices);
  const rows = new Uint32Array(used);
  remap.forEach((to, from) => { if (to < used) rows[to] = from; });
  writeIndices(document, primitive, used > 0xffff ? indices : Uint16Array.from(indices));
  // Accessors that others use as well stay as they are; those that attributes of this primitive share stay shared.
  const lighter = new Map();
  const lighterOf = (accessor) => {
    if (!lighter.has(accessor)) lighter.set(accessor, chosenRows(document, accessor, rows));
    return lighter.get(accessor);
  };
  for (const owner of [primitive, ...primitive.listTargets()]) {
    for (const semantic of owner.listSemantics()) owner.setAttribute(semantic, lighterOf(owner.getAttribute(semantic)));
  }
  [...lighter.keys()].forEach(disposeUnused);
}

function allAccessors(primitive) {
  return [primitive, ...primitive.listTargets()].flatMap((owner) => owner.listAttributes());
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

/** The first `width` numbers of each element as they mean. */
function readNumbers(accessor, width) {
  const numbers = new Float32Array(width * accessor.getCount());
  const element = [];
  for (let i = 0; i < accessor.getCount(); i++) {
    accessor.getElement(i, element);
    for (let j = 0; j < width; j++) numbers[width * i + j] = element[j];
  }
  return numbers;
}

function writeIndices(document, primitive, indices) {
  const old = primitive.getIndices();
  const buffer = old?.getBuffer() ?? primitive.getAttribute('POSITION').getBuffer();
  primitive.setIndices(document.createAccessor(old?.getName() ?? '', buffer).setType('SCALAR').setArray(indices));
  primitive.setMode(TRIANGLES);
  if (old) disposeUnused(old);
}

/** An accessor of chosen elements, else as the old one. */
function chosenRows(document, accessor, rows) {
  const array = gatherRows(accessor.getArray(), accessor.getElementSize(), rows);
  return document.createAccessor(accessor.getName(), accessor.getBuffer())
    .setType(accessor.getType()).setArray(array).setNormalized(accessor.getNormalized()).setSparse(accessor.getSparse())
    .setExtras(accessor.getExtras());
}

function dropPrimitive(mesh, primitive) {
  const owners = [primitive, ...primitive.listTargets()];
  const accessors = [primitive.getIndices(), ...allAccessors(primitive)].filter(Boolean);
  mesh.removePrimitive(primitive);
  owners.forEach((owner) => owner.dispose());
  new Set(accessors).forEach(disposeUnused);
}

/** Ends an accessor that only the document's list names. */
function disposeUnused(accessor) {
  if (accessor.listParents().every(({ propertyType }) => propertyType === 'Root')) accessor.dispose();
}

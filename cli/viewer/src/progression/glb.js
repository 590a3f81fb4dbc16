// GLB files of a level.

import { copyMaterials } from './materials.js';

const GLB = { magic: 0x46546c67, json: 0x4e4f534a, bin: 0x004e4942 };
const [FLOAT, WORD, VERTICES, CORNERS] = [5126, 5125, 34962, 34963];
/** The material of a mesh without materials. */
const PLAIN = { pbrMetallicRoughness: { metallicFactor: 0 }, doubleSided: true };
const TYPES = { 2: 'VEC2', 3: 'VEC3', 4: 'VEC4' };

/** Returns a level as GLB: one mesh, with a primitive for each material. */
export function writeGlb({ positions, faces, normal, uv, colour, origin, groups, materials }) {
  const [views, accessors, parts] = [[], [], []];
  const addBytes = (values, facts = {}) => {
    const byteOffset = parts.reduce((sum, part) => sum + part.byteLength, 0);
    // Arrays begin at multiples of four bytes.
    parts.push(values, new Uint8Array((4 - (values.byteLength % 4)) % 4));
    return views.push({ buffer: 0, byteOffset, byteLength: values.byteLength, ...facts }) - 1;
  };
  const add = (values, facts, target) => {
    return accessors.push({ bufferView: addBytes(values, { target }), ...facts }) - 1;
  };
  const addChannel = (width, values, bounds = {}) => add(values, { componentType: FLOAT, count: values.length / width, type: TYPES[width], ...bounds }, VERTICES);
  const attributes = { POSITION: addChannel(3, positions, boundsOf(positions)) };
  if (normal) attributes.NORMAL = addChannel(3, normal.values.map(unitOf(normal.values)));
  if (uv) attributes.TEXCOORD_0 = addChannel(2, uv.values.map((value, i) => (i % 2 === 1 ? 1 - value : value)));
  if (colour) attributes.COLOR_0 = addChannel(colour.width, colour.values.map((value, i) => (i % colour.width === 3 ? value : toLinear(value))));
  const primitives = facesByMaterial(faces, groups, materials?.ofGroups).map(([material, own]) => {
    const indices = add(own, { componentType: WORD, count: own.length, type: 'SCALAR' }, CORNERS);
    return { attributes, indices, ...(material === null ? {} : { material }) };
  });
  const looks = materials ? copyMaterials(materials, uv !== null, addBytes) : { materials: [PLAIN] };
  const node = { mesh: 0, ...(origin.every((x) => x === 0) ? {} : { translation: origin }) };
  const json = {
    asset: { version: '2.0', generator: 'neural-mesh' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [node],
    meshes: [{ primitives }], ...looks,
    accessors, bufferViews: views, buffers: [{ byteLength: parts.reduce((sum, part) => sum + part.byteLength, 0) }],
  };
  return packGlb(json, parts);
}

/** Returns pairs of a material and the corners of its faces; without materials, all faces have the first. */
function facesByMaterial(faces, groups, ofGroups) {
  if (!ofGroups) return [[0, faces]];
  const corners = new Map();
  groups.forEach((group, face) => {
    const material = ofGroups[group] ?? null;
    if (!corners.has(material)) corners.set(material, []);
    corners.get(material).push(faces[3 * face], faces[3 * face + 1], faces[3 * face + 2]);
  });
  return [...corners].map(([material, own]) => [material, Uint32Array.from(own)]);
}

/** Returns a function of a value and its index that scales directions to length 1; one without length points up. */
function unitOf(values) {
  return (value, i) => {
    const [x, y, z] = values.subarray(i - (i % 3), i - (i % 3) + 3);
    const length = Math.hypot(x, y, z);
    return length > 0 ? value / length : Number(i % 3 === 1);
  };
}

function toLinear(x) {
  return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
}

function boundsOf(positions) {
  const [min, max] = [[0, 0, 0].fill(Infinity), [0, 0, 0].fill(-Infinity)];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], x);
    max[i % 3] = Math.max(max[i % 3], x);
  });
  return { min, max };
}

function packGlb(json, parts) {
  const text = new TextEncoder().encode(JSON.stringify(json));
  // Chunks end at multiples of four bytes; all arrays hold numbers of four.
  const blanks = ' '.repeat((4 - (text.length % 4)) % 4);
  const nBytes = parts.reduce((sum, part) => sum + part.byteLength, 0);
  const [nJson, words] = [text.length + blanks.length, (...numbers) => Uint32Array.from(numbers)];
  return new Blob([
    words(GLB.magic, 2, 12 + 8 + nJson + 8 + nBytes), words(nJson, GLB.json), text, blanks, words(nBytes, GLB.bin), ...parts,
  ]);
}

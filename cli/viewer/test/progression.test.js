// Progressions without a browser: levels against those that the program makes, damage, steps of the slider.
//
// `scripts/viewer_test` makes NAME.nmp in PAGES, and its levels as levels/NAME.vertices-N.ply or levels/NAME.faces-N.ply; and placed.ply,
// a level of 90 vertices of placed.nmp, with the instances of its scene.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';
import { checksumOf } from '../src/progression/checksum.js';
import { closestWeights } from '../src/progression/attributes.js';
import { exportLevel } from '../src/progression/exported.js';
import { FORMATS } from '../src/progression/formats.js';
import { findLevel, meshOfLevel, openProgression } from '../src/progression/level.js';
import { PER_HALVING, sizesBetween } from '../src/progression/sizes.js';
import { readPly } from './ply.js';

const FOLDER = process.env.PAGES;
const NMP = readFileSync(`${FOLDER}/spot.nmp`);

const open = (bytes = NMP) => openProgression(new Blob([bytes]));
const limit = (kind, n) => ({ vertices: Infinity, faces: Infinity, [kind]: n });

/** Returns each triangle as text of its corners' positions, the first in order first, sorted. */
function trianglesOf({ positions, faces }) {
  const corner = (v) => positions.slice(3 * v, 3 * v + 3).join(' ');
  return Array.from({ length: faces.length / 3 }, (_, face) => {
    const corners = [...faces.subarray(3 * face, 3 * face + 3)].map(corner);
    const first = corners.indexOf([...corners].sort()[0]);
    return [0, 1, 2].map((k) => corners[(first + k) % 3]).join(', ');
  }).sort();
}

test('levels are those that the program makes', async () => {
  const seen = {};
  for (const file of readdirSync(`${FOLDER}/levels`)) {
    const [, name, kind, n] = file.match(/^(\w+)\.(vertices|faces)-(\d+)\.ply$/);
    const progression = await open(readFileSync(`${FOLDER}/${name}.nmp`));
    const level = findLevel(progression, limit(kind, Number(n)));
    const [found, made] = [meshOfLevel(progression, level), readPly(`${FOLDER}/levels/${file}`)];
    assert.deepEqual([found.positions.length / 3, found.faces.length / 3], [level.nVertices, level.nFaces], file);
    assert.deepEqual([level.nVertices, level.nFaces], [made.positions.length / 3, made.faces.length / 3], file);
    assert.deepEqual(trianglesOf(found), trianglesOf(made), file);
    (seen[name] ??= []).push(level.nDrops);
  }
  assert.deepEqual(Object.keys(seen).sort(), ['dust', 'sheets', 'spot']);
  assert.ok(Object.values(seen).every((drops) => drops.length >= 4));
  // Levels with all components, and without some of them.
  assert.ok(seen.dust.includes(0) && new Set(seen.dust).size > 1, `${seen.dust}`);
  assert.equal((await open(readFileSync(`${FOLDER}/sheets.nmp`))).isMesh, false);
});

test('levels within a limit grow one vertex at a time', async () => {
  const progression = await open();
  const counts = [];
  for (let n = 300; n < 340; n++) counts.push(findLevel(progression, limit('vertices', n)).nVertices);
  assert.deepEqual(counts, Array.from(counts, (_, i) => 300 + i));
  const smallest = findLevel(progression, limit('vertices', 1));
  assert.ok(smallest.nFaces >= 4 && smallest.nFaces < 20, `${smallest.nFaces}`);
});

const openNamed = (name) => open(readFileSync(`${FOLDER}/${name}.nmp`));
const bytesOf = async (format, level) => Buffer.from(await FORMATS[format](level).arrayBuffer());

/** Reads the arrays of a GLB of one primitive by their names. */
function readGlb(bytes) {
  assert.deepEqual([bytes.toString('latin1', 0, 4), bytes.readUInt32LE(8)], ['glTF', bytes.length]);
  const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
  const begin = 28 + bytes.readUInt32LE(12);
  const [{ attributes, indices }] = json.meshes[0].primitives;
  const read = (accessor) => {
    const { bufferView, componentType } = json.accessors[accessor];
    const { byteOffset, byteLength } = json.bufferViews[bufferView];
    const { buffer } = Uint8Array.from(bytes.subarray(begin + byteOffset, begin + byteOffset + byteLength));
    return componentType === 5125 ? new Uint32Array(buffer) : new Float32Array(buffer);
  };
  const arrays = Object.entries({ ...attributes, indices }).map(([name, accessor]) => [name, read(accessor)]);
  return { json, ...Object.fromEntries(arrays) };
}

test('files of a level have its triangles', async () => {
  for (const name of ['spot', 'dust', 'sheets']) {
    const progression = await openNamed(name);
    for (const n of [400, Infinity]) {
      const level = findLevel(progression, limit('vertices', n));
      const [expected, exported] = [trianglesOf(meshOfLevel(progression, level)), exportLevel(progression, level)];
      const { POSITION: positions, indices: faces, json } = readGlb(await bytesOf('glb', exported));
      assert.deepEqual(trianglesOf({ positions, faces }), expected);
      const box = [0, 1, 2].map((axis) => positions.filter((_, i) => i % 3 === axis).reduce((a, b) => Math.min(a, b)));
      assert.deepEqual(json.accessors[0].min, box);
      const stl = await bytesOf('stl', exported);
      const corners = Float32Array.from({ length: 9 * stl.readUInt32LE(80) }, (_, i) => stl.readFloatLE(84 + 50 * Math.floor(i / 9) + 12 + 4 * (i % 9)));
      assert.deepEqual(trianglesOf({ positions: corners, faces: Uint32Array.from({ length: corners.length / 3 }, (_, i) => i) }), expected);
      const lines = (await bytesOf('obj', exported)).toString().split('\n').map((line) => line.split(/[ /]+/));
      const numbers = (kind) => lines.filter(([first]) => first === kind).flatMap(([, ...rest]) => rest.slice(0, 3).map(Number));
      assert.deepEqual(trianglesOf({ positions: Float32Array.from(numbers('v')), faces: Uint32Array.from(numbers('f'), (v) => v - 1) }), expected);
      const ply = (await bytesOf('ply', exported)).toString('latin1', 0, 300);
      assert.match(ply, new RegExp(`^ply\nformat binary_little_endian 1.0\nelement vertex ${exported.positions.length / 3}\n`));
      assert.match(ply, new RegExp(`element face ${level.nFaces}\n`));
    }
  }
});

test('texture coordinates of a level are those of the closest points', async () => {
  const progression = await openNamed('plate');
  for (const n of [30, 120, Infinity]) {
    const level = findLevel(progression, limit('vertices', n));
    const { positions, uv, faces } = exportLevel(progression, level);
    assert.equal(faces.length, 3 * level.nFaces);
    // The plate has its coordinates over 24 as texture coordinates, and waves along the third axis.
    for (let v = 0; v < positions.length / 3; v++) {
      const off = Math.hypot(24 * uv.values[2 * v] - positions[3 * v], 24 * uv.values[2 * v + 1] - positions[3 * v + 1]);
      assert.ok(off < (n === Infinity ? 1e-5 : 1.2), `${n}: ${off}`);
    }
    const { TEXCOORD_0: flipped } = readGlb(await bytesOf('glb', { ...exportLevel(progression, level) }));
    assert.ok(flipped.every((value, i) => Math.abs(value - (i % 2 === 1 ? 1 - uv.values[i] : uv.values[i])) < 1e-6));
  }
});

test('closest points of a triangle are those of many samples', () => {
  const random = (seed) => (Math.sin(seed * 12.9898) * 43758.5453) % 1;
  for (let turn = 1; turn < 60; turn++) {
    const positions = Float32Array.from({ length: 9 }, (_, i) => random(9 * turn + i));
    const point = [1, 2, 3].map((i) => 2 * random(1000 + 3 * turn + i));
    const { weights, distance } = closestWeights(positions, [0, 1, 2], point);
    assert.ok(weights.every((weight) => weight >= 0) && Math.abs(weights[0] + weights[1] + weights[2] - 1) < 1e-6);
    let least = Infinity;
    for (let i = 0; i <= 60; i++) {
      for (let j = 0; i + j <= 60; j++) {
        const at = [0, 1, 2].map((axis) => (i * positions[axis] + j * positions[3 + axis] + (60 - i - j) * positions[6 + axis]) / 60);
        least = Math.min(least, at.reduce((sum, x, axis) => sum + (x - point[axis]) ** 2, 0));
      }
    }
    assert.ok(distance <= least + 1e-9 && Math.sqrt(least) - Math.sqrt(distance) < 0.06, `${turn}: ${distance} ${least}`);
  }
});

test('a GLB keeps the materials and textures of a GLB', async () => {
  const progression = await openNamed('textured');
  for (const n of [150, Infinity]) {
    const level = findLevel(progression, limit('vertices', n));
    const bytes = await bytesOf('glb', exportLevel(progression, level));
    const { json } = readGlb(bytes);
    assert.deepEqual([json.images.length, json.materials.length, json.textures.length], [1, 2, 1]);
    const { byteOffset, byteLength } = json.bufferViews[json.images[0].bufferView];
    const image = bytes.subarray(28 + bytes.readUInt32LE(12) + byteOffset).subarray(0, byteLength);
    assert.ok(image.equals(readFileSync(`${FOLDER}/maps/skin.png`)));
    // The strip of the other material is along the lower edge.
    const [{ primitives }] = json.meshes;
    assert.deepEqual(primitives.map(({ material }) => material).sort(), [0, 1]);
    assert.equal(primitives.reduce((sum, { indices }) => sum + json.accessors[indices].count, 0), 3 * level.nFaces);
  }
});

test('instances of a scene are placed as the program places them', async () => {
  const progression = await openNamed('placed');
  const level = findLevel(progression, limit('vertices', 90));
  const [made, exported] = [readPly(`${FOLDER}/placed.ply`), exportLevel(progression, level)];
  assert.deepEqual([exported.faces.length, exported.faces.length], [made.faces.length, 9 * level.nFaces]);
  const measure = ({ positions, faces }) => {
    const axes = [0, 1, 2].map((axis) => [...positions.filter((_, i) => i % 3 === axis)]);
    const middle = axes.map((values) => (Math.min(...values) + Math.max(...values)) / 2);
    let volume = 0;
    for (let i = 0; i < faces.length; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => middle.map((x, axis) => positions[3 * faces[i + k] + axis] - x));
      volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
    }
    return [...axes.map((values) => Math.max(...values) - Math.min(...values)), volume];
  };
  const [own, theirs] = [measure(exported), measure(made)];
  own.forEach((value, i) => assert.ok(Math.abs(value / theirs[i] - 1) < 1e-4, `${own} ${theirs}`));
  // Three spheres that all turn outwards.
  assert.ok(own[3] > 20, `${own}`);
});

/** Returns a copy of the file with changed bytes, and a checksum that fits them. */
async function changed(at, bytes) {
  const copy = Buffer.from(NMP);
  Buffer.from(bytes).copy(copy, at);
  const sum = await checksumOf(copy.subarray(0, copy.length - 8));
  sum.forEach((half, i) => copy.writeUInt32LE(half >>> 0, copy.length - 8 + 4 * i));
  return copy;
}

test('damage is told in one line', async () => {
  const flipped = Buffer.from(NMP);
  flipped[1000] ^= 1;
  const afterPositions = 20 + 12 * NMP.readUInt32LE(12);
  const cases = [
    [Buffer.from('glTF'), /^no progression: the first bytes are not "NMESHPRG"$/],
    [Buffer.alloc(0), /^no progression/],
    [NMP.subarray(0, 15), /the file is cut off$/],
    [await changed(8, [9]), /^version 9 of the format, but 2 is read here: make the file again$/],
    [flipped, /^damaged progression: the checksum does not fit$/],
    [NMP.subarray(0, NMP.length - 1), /the checksum does not fit$/],
    [await changed(12, [255, 255, 255, 255]), /a list is longer than the file$/],
    [await changed(12, [0, 0, 0, 0, 0, 0, 0, 1]), /an impossible number$|a list is longer than the file$/],
    [await changed(20, [0, 0, 0xc0, 0x7f]), /a position that is not finite$/],
    [await changed(afterPositions + 8, [255, 255, 255, 1]), /a face with an unknown vertex$/],
  ];
  for (const [bytes, message] of cases) {
    await assert.rejects(open(bytes), (error) => message.test(error.message) && !error.message.includes('\n'), `${message}`);
  }
});

test('any changed byte gives an error or levels', async () => {
  let nRead = 0;
  for (let at = 12; at < NMP.length - 8; at += 3701) {
    const progression = await open(await changed(at, [NMP[at] ^ 0xff])).catch((error) => assert.match(error.message, /^damaged/));
    if (!progression) continue;
    nRead++;
    const { faces } = meshOfLevel(progression, findLevel(progression, limit('vertices', 100)));
    assert.ok(faces.length > 0);
  }
  assert.ok(nRead > 10, `${nRead}`);
});

test('the slider halves sizes, and proved levels are easy to meet', () => {
  const plain = sizesBetween(10, 1000, []);
  assert.deepEqual([plain[0], plain.at(-1), plain.at(-1 - PER_HALVING)], [10, 1000, 500]);
  assert.ok(plain.every((n, i) => i === 0 || n >= plain[i - 1]));
  const proved = sizesBetween(10, 1001, [{ nVertices: 500 }, { nVertices: 250 }]);
  assert.equal(proved.filter((n) => n === 500).length, 5);
  assert.equal(proved.at(-1 - PER_HALVING), 500);
  assert.deepEqual(sizesBetween(4, 4, []), [4, 4]);
});

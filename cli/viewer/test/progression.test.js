// Progressions without a browser: levels against those that the program makes, damage, steps of the slider.
//
// `scripts/viewer_test` makes NAME.nmp in PAGES, and its levels as levels/NAME.vertices-N.ply or levels/NAME.faces-N.ply.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';
import { checksumOf } from '../src/progression/checksum.js';
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

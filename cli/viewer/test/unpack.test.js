// What the program packs, the page unpacks: the original of several.html is Spot, closed, in its box, with every vertex used.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { inflateRawSync } from 'node:zlib';
import { refined } from '../src/refine.js';
import { allEdges, unpackCover, unpackShares, unpackSurface } from '../src/surface.js';

const page = readFileSync(`${process.env.PAGES}/several.html`, 'utf8');
const textured = readFileSync(`${process.env.PAGES}/textured.html`, 'utf8');
const wordsOf = (page) => JSON.parse(page.match(/id="comparison">(.*?)<\/script>/)[1]);
const words = wordsOf(page);

function numbersOf(name, from = page) {
  const parts = [...from.matchAll(new RegExp(`data-of="${name}">([^<]*)<`, 'g'))];
  const bytes = inflateRawSync(Buffer.concat(parts.map(([, text]) => Buffer.from(text, 'base64'))));
  return { bytes, at: 0 };
}

const layout = words.surfaces[0];
const place = { centre: [0, 0, 0], scale: 1 };

test('a mesh comes back whole', async () => {
  const numbers = numbersOf('surface-0');
  const surface = await unpackSurface(layout, numbers, place);
  assert.equal(numbers.at, numbers.bytes.length);
  const edges = await allEdges(surface);
  assert.equal(new Set(surface.faces).size, layout.vertices);
  assert.equal(layout.vertices - edges.length / 2 + layout.faces, 2);
  for (let axis = 0; axis < 3; axis++) {
    const along = surface.positions.filter((_, i) => i % 3 === axis);
    const [low, high] = [along.reduce((a, b) => Math.min(a, b)), along.reduce((a, b) => Math.max(a, b))];
    assert.ok(Math.abs(low - layout.low[axis]) <= layout.step);
    assert.ok(Math.abs(high - low - layout.sides[axis]) <= layout.step);
  }
});

test('every point has its distance, the largest of all is 1', async () => {
  const points = ({ vertices, faces, steps }) => (steps === 1 ? vertices : (faces * (steps + 1) * (steps + 2)) / 2);
  let largest = 0;
  for (let index = 1; index < words.surfaces.length; index++) {
    const numbers = numbersOf(`distances-${index}`);
    for (const surface of [words.surfaces[index], layout]) {
      const shares = await unpackShares(points(surface), numbers);
      for (let i = 0; i < shares.length; i += 2) largest = Math.max(largest, shares[i]);
    }
    assert.equal(numbers.at, numbers.bytes.length);
  }
  assert.equal(largest, 1);
});

test('a cover comes back with its surface', async () => {
  const { surfaces, covers } = wordsOf(textured);
  const surface = await unpackSurface(surfaces[0], numbersOf('surface-0', textured), place);
  const numbers = numbersOf('cover-0', textured);
  const cover = await unpackCover(covers[0], numbers, surface);
  assert.equal(numbers.at, numbers.bytes.length);
  assert.deepEqual(covers[0].paints.map(({ image }) => image), [null, 0]);
  assert.deepEqual(cover.runs, [[0, 3 * 2 * 4 * 24], [3 * 2 * 4 * 24, 3 * 2 * 20 * 24]]);
  // The texture lies flat on the plate, its upper edge, v = 0, where y is largest.
  for (const wedge of cover.faces.subarray(cover.runs[1][0])) {
    const [x, y] = cover.positions.subarray(3 * wedge, 3 * wedge + 2);
    const [u, v] = cover.uvs.subarray(2 * wedge, 2 * wedge + 2);
    assert.ok(Math.abs(u - x / 24) < 1e-4 && Math.abs(1 - v - y / 24) < 1e-4, `${x} ${y} ${u} ${v}`);
  }
});

test('smaller faces cover the same surface', async () => {
  const surface = await unpackSurface(layout, numbersOf('surface-0'), place);
  const fine = await refined(surface, 3);
  assert.equal(fine.faces.length, 9 * surface.faces.length);
  assert.ok(Math.abs(volume(fine) / volume(surface) - 1) < 1e-4 && volume(surface) > 0);
});

/** Six times the volume inside a closed surface. */
function volume({ positions, faces }) {
  let sum = 0;
  const corner = (i) => positions.subarray(3 * faces[i], 3 * faces[i] + 3);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [corner(i), corner(i + 1), corner(i + 2)];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum;
}

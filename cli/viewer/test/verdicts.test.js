// Figures in words: sizes, closeness and closedness are said as measured, and the best value of a row is found.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bestColumns, headline, percentOff, spokenBytes, tell, times } from '../src/verdicts.js';

const ORIGINAL = { faces: 5856, vertices: 2930, bytes: 147_000, boundary_edges: 0, non_manifold_edges: 0 };
const VALUES = { distance_mean: 0.0807, distance_max: 0.899, boundary_edges: 0, non_manifold_edges: 0 };
const said = (original, result) => headline({ original: { ...ORIGINAL, ...original }, result: { faces: 582, bytes: 11_300, values: VALUES, ...result } });

test('the headline is what a reader repeats', () => {
  assert.deepEqual(said({}, {}).map(({ value }) => value), ['13× smaller', '0.08 % of its size off', 'closed']);
});

test('a file that is mostly textures is no reason to say smaller', () => {
  assert.equal(said({ bytes: 1_000_000 }, { bytes: 900_000 })[0].value, '10× fewer triangles');
  assert.equal(said({ bytes: undefined }, {})[0].value, '10× fewer triangles');
});

test('holes are said, and whose they are', () => {
  const open = { values: { ...VALUES, boundary_edges: 7 } };
  assert.deepEqual([said({}, open)[2].value, said({}, open)[2].grade], ['holes', 'poor']);
  assert.deepEqual([said({ boundary_edges: 9 }, open)[2].value, said({ boundary_edges: 9 }, open)[2].grade], ['open as before', 'fair']);
});

test('without a measurement nothing is claimed', () => {
  assert.deepEqual(said({}, { values: undefined }).slice(1).map(({ grade }) => grade), ['none', 'none']);
  assert.deepEqual(tell('distance_mean', null, { original: ORIGINAL }).value, '–');
});

test('a thousandth of the diagonal is a pixel of a thousand', () => {
  assert.equal(tell('distance_mean', 0.1, {}).words, '1 pixel of 1,000');
  assert.deepEqual([0.05, 0.2, 0.9].map((value) => tell('distance_mean', value, {}).grade), ['good', 'fair', 'poor']);
});

test('the best value is the least, the largest, or that nearest to zero', () => {
  assert.deepEqual(bestColumns('distance_mean', [0.3, 0.1, null]), [1]);
  assert.deepEqual(bestColumns('ssim', [0.3, 0.9]), [1]);
  assert.deepEqual(bestColumns('volume_change', [-0.3, 0.1]), [1]);
  assert.deepEqual(bestColumns('faces', [5, 5]), []);
});

test('numbers are as short as they are true', () => {
  assert.deepEqual([times(5856, 582), times(3, 2), times(1, 0)], ['10×', '1.5×', '–']);
  assert.deepEqual([spokenBytes(999), spokenBytes(11_340), spokenBytes(1_234_567)], ['999 bytes', '11.3 kB', '1.23 MB']);
  assert.deepEqual([0, 0.0005, 0.0123, 0.456].map((mean) => percentOff(mean)), ['0 % off', '< 0.001 % off', '0.01 % off', '0.46 % off']);
});

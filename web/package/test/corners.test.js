// Tests that corners at vertices of another part get copies.

import assert from 'node:assert/strict';
import test from 'node:test';

import { separateParts } from '../src/corners.js';

// Two parts of three vertices each, along a line.
const positions = Float32Array.of(0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0);
const starts = [0, 3, 6];

test('triangles of their own vertices stay', () => {
  const indices = Uint32Array.of(0, 1, 2, 5, 4, 3);
  const own = Uint32Array.of(0, 1, 2, 3, 4, 5);
  assert.deepEqual(separateParts({ indices, groups: Uint32Array.of(0, 1) }, positions, starts), { indices, sources: own, looks: own });
});

test('a corner of another part is copied once for its part', () => {
  const given = { indices: Uint32Array.of(0, 1, 4, 1, 0, 4, 1, 4, 5), groups: Uint32Array.of(0, 0, 1) };
  const { indices, sources, looks } = separateParts(given, positions, starts);
  assert.deepEqual(indices, Uint32Array.of(0, 1, 6, 1, 0, 6, 7, 4, 5));
  assert.deepEqual([...sources.subarray(6)], [4, 1]);
  assert.deepEqual([...looks.subarray(6)], [2, 3]);
});

test('nothing is nothing', () => {
  const none = new Uint32Array(0);
  assert.deepEqual(separateParts({ indices: none, groups: none }, new Float32Array(0), [0]), { indices: none, sources: none, looks: none });
});

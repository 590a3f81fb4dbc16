// Welds vertices at equal positions, such as those split at seams.

import { breathe } from '../../../cli/viewer/src/slices.js';

/** Returns the point of each vertex, n_vertices, and the first vertex at each point, n_points. */
export async function weldVertices(positions) {
  const n = positions.length / 3;
  const bits = new Uint32Array(positions.buffer, positions.byteOffset, positions.length);
  const size = 2 ** Math.ceil(Math.log2(2 * n + 1));
  const table = new Int32Array(size).fill(-1);
  const pointOf = new Uint32Array(n);
  const firstOf = new Uint32Array(n);
  let nPoints = 0;
  const isSame = (a, b) => (
    positions[a] === positions[b] && positions[a + 1] === positions[b + 1] && positions[a + 2] === positions[b + 2]);
  for (let vertex = 0; vertex < n; vertex++) {
    if (vertex % 32768 === 0) await breathe();
    const at = 3 * vertex;
    let slot = hash(bits, positions, at) & (size - 1);
    while (table[slot] >= 0 && !isSame(3 * firstOf[table[slot]], at)) slot = (slot + 1) & (size - 1);
    if (table[slot] < 0) {
      table[slot] = nPoints;
      firstOf[nPoints++] = vertex;
    }
    pointOf[vertex] = table[slot];
  }
  return { pointOf, firstOf: firstOf.subarray(0, nPoints) };
}

/** Hashes a position; 0 and -0 have equal hashes. */
function hash(bits, positions, at) {
  let sum = 0;
  for (let axis = 0; axis < 3; axis++) {
    sum = Math.imul(sum ^ (positions[at + axis] === 0 ? 0 : bits[at + axis]), 0x9e3779b1);
    sum ^= sum >>> 15;
  }
  return sum >>> 0;
}

// Decodes the values of all meshes. The encoder is points.rs of the program.

import { numbersOf, readEach } from './numbers.js';

/** Returns a function that unpacks a column on first use: n_ratios x n_methods x n_meshes values, NaN for missing ones. */
export function pointsOf({ overview: { ratios, methods }, meshes }) {
  const n = ratios.length * methods.length * meshes.length;
  const known = new Map();
  return (column) => {
    if (!known.has(column)) known.set(column, numbersOf(`points-${column}`).then((numbers) => unpackValues(numbers, n)));
    return known.get(column);
  };
}

/** Decodes values: 0 for a missing value, else one more than the first 21 bits of its number. */
export async function unpackValues(numbers, n) {
  const bits = new Uint32Array(n);
  const values = new Float32Array(bits.buffer);
  await readEach(numbers, n, (number, i) => {
    if (number === 0) values[i] = NaN;
    else bits[i] = (number - 1) << 11;
  });
  return values;
}

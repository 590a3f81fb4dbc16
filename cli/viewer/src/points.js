// The values of all meshes back to numbers. The way into the page is points.rs of the program.

import { numbersOf, readEach } from './numbers.js';

/** Gives the values of a column, n_ratios x n_methods x n_meshes, NaN where there is none; unpacks each when it is first asked for. */
export function pointsOf({ overview: { ratios, methods }, meshes }) {
  const n = ratios.length * methods.length * meshes.length;
  const known = new Map();
  return (column) => {
    if (!known.has(column)) known.set(column, numbersOf(`points-${column}`).then((numbers) => unpackValues(numbers, n)));
    return known.get(column);
  };
}

/** Each value is 0 for none, or one more than the first 21 bits of its number. */
export async function unpackValues(numbers, n) {
  const bits = new Uint32Array(n);
  const values = new Float32Array(bits.buffer);
  await readEach(numbers, n, (number, i) => {
    if (number === 0) values[i] = NaN;
    else bits[i] = (number - 1) << 11;
  });
  return values;
}

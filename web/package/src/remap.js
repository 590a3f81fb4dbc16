// Renumbers vertices: in the order of their first use, and by equal content. Plain loops that need no WebAssembly.

/** New number of an unused vertex. */
export const UNUSED = 0xffffffff;

/**
 * Renumbers vertices in the order of their first use, and writes the new numbers into `indices`.
 *
 * @returns {[Uint32Array, number]} the new number of each vertex up to the largest in use, `UNUSED` for unused ones, and the number of
 *   used vertices
 */
export function compactIndices(indices) {
  const remap = new Uint32Array(indices.reduce((most, index) => Math.max(most, index), -1) + 1).fill(UNUSED);
  let used = 0;
  for (let i = 0; i < indices.length; i++) {
    if (remap[indices[i]] === UNUSED) remap[indices[i]] = used++;
    indices[i] = remap[indices[i]];
  }
  return [remap, used];
}

/**
 * Finds for each row the first row with equal bits in all columns.
 *
 * @param {Array<{words: Uint32Array, width: number}>} columns rows of `width` words each, all of equally many rows
 * @param {number} nRows
 * @returns {Uint32Array} one number per row, at most its own
 */
export function firstEqualRows(columns, nRows) {
  // Open addressing at a load of at most one half.
  const mask = 2 ** Math.ceil(Math.log2(2 * nRows + 2)) - 1;
  const table = new Uint32Array(mask + 1).fill(UNUSED);
  const first = new Uint32Array(nRows);
  for (let row = 0; row < nRows; row++) {
    let slot = hashRow(columns, row) & mask;
    while (table[slot] !== UNUSED && !areEqual(columns, table[slot], row)) slot = (slot + 1) & mask;
    if (table[slot] === UNUSED) table[slot] = row;
    first[row] = table[slot];
  }
  return first;
}

function hashRow(columns, row) {
  let hash = 0x811c9dc5;
  for (const { words, width } of columns) {
    for (let i = row * width; i < (row + 1) * width; i++) hash = Math.imul(hash ^ words[i], 0x01000193) ^ (hash >>> 15);
  }
  return (hash ^ (hash >>> 16)) >>> 0;
}

function areEqual(columns, one, other) {
  return columns.every(({ words, width }) => {
    for (let i = 0; i < width; i++) if (words[one * width + i] !== words[other * width + i]) return false;
    return true;
  });
}

/** Returns numbers as 32-bit words that are equal for equal numbers: integers as such, others as single-precision bits without -0. */
export function wordsOf(array) {
  if (/^(Int|Uint)/.test(array.constructor.name)) return Uint32Array.from(array);
  return new Uint32Array(Float32Array.from(array, (value) => value + 0).buffer);
}

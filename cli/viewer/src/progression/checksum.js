// Checksum of `.nmp` files: words of 8 bytes, each mixed in by a product modulo 2^64 and a rotation.

import { inSlices } from '../slices.js';

/** Halves of the factor 0x9e3779b97f4a7c15. */
const LOW = 0x7f4a7c15;
const HIGH = 0x9e3779b9;
const ROTATION = 29;

/** Returns the checksum of bytes, its lower and upper half. */
export async function checksumOf(bytes) {
  const sum = new Uint32Array([bytes.length, bytes.length / 2 ** 32]);
  const nWords = Math.floor(bytes.length / 8);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  await inSlices(nWords, (from, to) => {
    for (let at = 8 * from; at < 8 * to; at += 8) mix(sum, view.getUint32(at, true), view.getUint32(at + 4, true));
  });
  for (const byte of bytes.subarray(8 * nWords)) mix(sum, byte, 0);
  return [...sum];
}

function mix(sum, wordLow, wordHigh) {
  const low = sum[0] ^ wordLow;
  const high = (highProduct(low >>> 0, LOW) + Math.imul(low, HIGH) + Math.imul(sum[1] ^ wordHigh, LOW)) | 0;
  const product = Math.imul(low, LOW);
  sum[0] = (product << ROTATION) | (high >>> (32 - ROTATION));
  sum[1] = (high << ROTATION) | (product >>> (32 - ROTATION));
}

/** Returns the upper 32 bits of a product of 32-bit numbers, by halves of 16 bits. */
function highProduct(a, b) {
  const [aLow, aHigh] = [a & 0xffff, a >>> 16];
  const [bLow, bHigh] = [b & 0xffff, b >>> 16];
  // Sums below 2^53 are exact.
  const middle = aHigh * bLow + ((aLow * bLow) >>> 16);
  return aHigh * bHigh + Math.floor(middle / 65536) + Math.floor(((middle % 65536) + aLow * bHigh) / 65536);
}

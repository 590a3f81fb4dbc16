// Decodes text in the page to whole numbers: base64, inflated, seven bits per byte. The encoder is packed.rs of the program.

import { breathe, inSlices } from './slices.js';

/** Opens the numbers of a name for reading from the front. */
export async function numbersOf(name) {
  const stream = new Blob(await bytesOf(name)).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return { bytes: new Uint8Array(await new Response(stream).arrayBuffer()), at: 0 };
}

/** Yields the bytes in the script elements of a name, element by element. */
export async function bytesOf(name) {
  const parts = [];
  for (const { textContent } of document.querySelectorAll(`[data-of="${name}"]`)) {
    parts.push(Uint8Array.from(atob(textContent), (letter) => letter.charCodeAt(0)));
    await breathe();
  }
  return parts;
}

/** Reads n numbers and passes each to `take(number, i)`. */
export async function readEach(numbers, n, take) {
  await inSlices(n, (from, to) => {
    let at = numbers.at;
    for (let i = from; i < to; i++) {
      let byte = numbers.bytes[at++];
      let number = byte & 127;
      for (let shift = 7; byte > 127; shift += 7) {
        byte = numbers.bytes[at++];
        number |= (byte & 127) << shift;
      }
      take(number >>> 0, i);
    }
    numbers.at = at;
  });
}

/** Reads n numbers stored as differences to the previous one, and passes each to `take(number, i)`. */
export async function readDifferences(numbers, n, take) {
  let before = 0;
  await readEach(numbers, n, (difference, i) => {
    before += (difference >>> 1) ^ -(difference & 1);
    take(before, i);
  });
}

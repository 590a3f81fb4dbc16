// Text in the page back to whole numbers: base64, inflated, seven bits a byte. The way there is packed.rs of the program.

import { breathe, inSlices } from './slices.js';

/** Letters that are decoded at once; a multiple of four. */
const LETTERS = 1 << 18;

/** The numbers of the script element with that id, to be read from the front. */
export async function numbersOf(id) {
  const deflated = await decoded(document.getElementById(id).textContent);
  const stream = new Blob(deflated).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return { bytes: new Uint8Array(await new Response(stream).arrayBuffer()), at: 0 };
}

async function decoded(text) {
  const parts = [];
  for (let at = 0; at < text.length; at += LETTERS) {
    parts.push(Uint8Array.from(atob(text.slice(at, at + LETTERS)), (letter) => letter.charCodeAt(0)));
    await breathe();
  }
  return parts;
}

/** Reads n numbers, each through `take(number, i)`. */
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

/** Reads n numbers stored as differences from the one before, each through `take(number, i)`. */
export async function readDifferences(numbers, n, take) {
  let before = 0;
  await readEach(numbers, n, (difference, i) => {
    before += (difference >>> 1) ^ -(difference & 1);
    take(before, i);
  });
}

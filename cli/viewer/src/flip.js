// Maps of the FLIP error: what an eye notices between pictures of original and result, from four sides.

import { colourAt } from './colours.js';
import { bytesOf } from './numbers.js';

/** FLIP error that has the last colour; larger ones are rare. */
const END = 0.8;

/** Draws the maps of a result, each [width, height], in two rows into a canvas; pixels without a difference stay clear. */
export async function drawFlip(canvas, name, maps) {
  const stream = new Blob(await bytesOf(name)).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const errors = new Uint8Array(await new Response(stream).arrayBuffer());
  const [width, height] = [0, 1].map((side) => Math.max(...maps.map((map) => map[side])));
  Object.assign(canvas, { width: 2 * width, height: 2 * height });
  const context = canvas.getContext('2d');
  let at = 0;
  maps.forEach(([w, h], i) => {
    const image = context.createImageData(w, h);
    for (let pixel = 0; pixel < w * h; pixel++) {
      const error = errors[at + pixel] / 255;
      image.data.set([...colourAt(Math.min(error / END, 1)), Math.min(error * 12, 1) * 255], 4 * pixel);
    }
    at += w * h;
    context.putImageData(image, (i % 2) * width + Math.floor((width - w) / 2), Math.floor(i / 2) * height);
  });
}

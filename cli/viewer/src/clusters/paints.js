// Base colours of the input: textures and colours that the program wrote beside the file, and which material has which.

import { decode, makeTexture } from '../cover.js';
import { bytesOf } from '../numbers.js';

/** Paints of a file that comes alone: one plain colour. */
export const PLAIN = { all: [{ map: null, colour: [1, 1, 1], isCut: false }], paintOf: () => 0, isVUp: false, hasTextures: false };

/**
 * Loads the paints that the page describes: `paints` {image, wrap, colour, isCut}, the paint of each material in `groups`, and the types of
 * images, and whether v grows upwards. Images that the browser cannot read are left out.
 */
export async function loadPaints({ paints = [], groups = [], images = [], isVUp = false }) {
  if (paints.length === 0) return PLAIN;
  const bitmaps = await Promise.all(images.map((type, index) => load(index, type).catch(() => null)));
  const all = paints.map(({ image, wrap, ...paint }) => ({ map: bitmaps[image] ? makeTexture(bitmaps[image], wrap) : null, ...paint }));
  return { all, paintOf: (group) => groups[group] ?? 0, isVUp, hasTextures: true };
}

async function load(index, type) {
  return decode(new Blob(await bytesOf(`image-${index}`), { type }));
}

// The colour scale of distances, magma, which is perceptually even and readable for colour-blind people; and its texture.

import { ClampToEdgeWrapping, DataTexture, LinearFilter, SRGBColorSpace } from 'three';

/**
 * Eight even steps of matplotlib's magma (CC0) from its light end.
 *
 * Distance 0 is light, so that shapes and edges stay visible there. The last, nearly black steps are left out.
 */
const STEPS = ['fcfdbf', 'feca8d', 'fd9668', 'f1605d', 'cd4071', '9e2f7f', '721f81', '440f76'];

const TEXELS = 256;

/** Colour scale as a CSS gradient from left to right. */
export const GRADIENT = `linear-gradient(to right, ${STEPS.map((step) => `#${step}`).join(', ')})`;

/** Creates a texture of one row of colours; `repeat.x` is the part of it that a share of 1 spans. */
export function colourTexture() {
  const texture = new DataTexture(Uint8Array.from(texels()), TEXELS, 1);
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function texels() {
  return Array.from({ length: TEXELS }, (_, i) => [...colourAt(i / (TEXELS - 1)), 255]).flat();
}

/** Returns red, green and blue at a share of the scale, 0 to 255 each. */
export function colourAt(share) {
  const along = share * (STEPS.length - 1);
  const step = Math.min(Math.floor(along), STEPS.length - 2);
  const [low, high] = [channels(STEPS[step]), channels(STEPS[step + 1])];
  return low.map((value, i) => Math.round(value + (high[i] - value) * (along - step)));
}

function channels(step) {
  return [0, 2, 4].map((at) => parseInt(step.slice(at, at + 2), 16));
}

// What metal and polished surfaces reflect: a bright sky with a lamp over a grey ground.

import { DataTexture, EquirectangularReflectionMapping, LinearFilter, PMREMGenerator } from 'three';

const [WIDTH, HEIGHT] = [64, 32];

/** Returns the texture of what surfaces of a view reflect, made for the first of them. */
export function reflectedOf(view) {
  view.reflected ??= makeReflected(view.renderer);
  return view.reflected;
}

function makeReflected(renderer) {
  const panorama = new DataTexture(Uint8Array.from(texels()), WIDTH, HEIGHT);
  Object.assign(panorama, { mapping: EquirectangularReflectionMapping, magFilter: LinearFilter, minFilter: LinearFilter, needsUpdate: true });
  const generator = new PMREMGenerator(renderer);
  const { texture } = generator.fromEquirectangular(panorama);
  generator.dispose();
  panorama.dispose();
  return texture;
}

/** Returns red, green, blue and alpha of the panorama, from its lowest row up. */
function texels() {
  return Array.from({ length: WIDTH * HEIGHT }, (_, i) => {
    const [across, up] = [(i % WIDTH) / WIDTH, (Math.floor(i / WIDTH) + 0.5) / HEIGHT];
    const isLamp = up > 0.62 && up < 0.85 && across % 0.5 > 0.08 && across % 0.5 < 0.26;
    const light = isLamp ? 255 : up < 0.5 ? 60 + 60 * up : 110 + 120 * (up - 0.5);
    return [light, light, light, 255].map(Math.round);
  }).flat();
}

// What is around the meshes of any page: switches, keys, the words while something is going on.

import { listen } from './keys.js';
import { setSwitches } from './scene.js';
import { lookFromStart } from './view.js';

const at = (id) => document.getElementById(id);

/** Wires up the controls of a scene; what it gives back applies switches that a script has set. */
export function wireStage(scene) {
  listen(scene.view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(scene.view));
  wireTexture();
  return wireSwitches(scene);
}

/** Shows the switch of textures where a mesh has one. */
export function offerTexture(isThere) {
  at('texture').disabled = !isThere;
  at('texture').parentElement.hidden = !isThere;
}

/** A surface has one kind of colours at a time. */
function wireTexture() {
  const [texture, colours] = [at('texture'), at('colours')];
  texture.addEventListener('change', () => { if (texture.checked) colours.checked = false; });
  colours.addEventListener('change', () => { if (colours.checked) texture.checked = false; });
}

function wireSwitches(scene) {
  const boxes = [...document.querySelectorAll('[data-switch]')];
  const update = () => {
    at('scale').hidden = !at('colours').checked;
    document.documentElement.toggleAttribute('data-texture', at('texture').checked);
    return attempt(setSwitches(scene, Object.fromEntries(boxes.map((box) => [box.dataset.switch, box.checked]))));
  };
  boxes.forEach((box) => box.addEventListener('change', update));
  update();
  return update;
}

/** Says what is going on, over the meshes; nothing where there are no words. */
export function wait(words) {
  at('wait').textContent = words;
  at('wait').hidden = words === '';
}

/** Tells tests and measurements that the page is there. */
export function markFirstDraw() {
  if (document.documentElement.dataset.state === 'ready') return;
  document.documentElement.dataset.state = 'ready';
  performance.mark('first-draw');
}

/** What goes wrong is said in the page. */
export function attempt(work) {
  return work.catch(fail);
}

/** Says in the page that meshes cannot be shown. */
export function fail(error) {
  console.error(error);
  wait(`The meshes cannot be shown: ${error.message}. The numbers are complete. A browser of 2023 or newer with WebGL is needed.`);
}

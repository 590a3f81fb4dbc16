// Controls around the meshes of any page: switches, keys, and messages about work in progress.

import { listen } from './keys.js';
import { setSwitches } from './scene.js';
import { lookFromStart } from './view.js';

const at = (id) => document.getElementById(id);

/** Wires up the controls of a scene; the returned function applies switches that a script has set. */
export function wireStage(scene) {
  listen(scene.view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(scene.view));
  exclude(at('texture'), at('colours'));
  exclude(at('wipe'), document.querySelector('[data-switch="four"]'));
  return wireSwitches(scene);
}

/** Shows the texture switch if a mesh has a texture. */
export function offerTexture(isThere) {
  at('texture').disabled = !isThere;
  at('texture').parentElement.hidden = !isThere;
}

/** Keeps two switches exclusive: a surface shows one kind of colours, and four views have no common divider. */
function exclude(one, other) {
  for (const [box, its] of [[one, other], [other, one]]) {
    box.addEventListener('change', () => {
      if (!box.checked || !its.checked) return;
      its.checked = false;
      its.dispatchEvent(new Event('change'));
    });
  }
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

/** Shows a message over the meshes; an empty string hides it. */
export function wait(words) {
  at('wait').textContent = words;
  at('wait').hidden = words === '';
}

/** Signals to tests and measurements that the page is drawn. */
export function markFirstDraw() {
  if (document.documentElement.dataset.state === 'ready') return;
  document.documentElement.dataset.state = 'ready';
  performance.mark('first-draw');
}

/** Shows errors in the page. */
export function attempt(work) {
  return work.catch(fail);
}

/** Shows that the meshes cannot be displayed, and why. */
export function fail(error) {
  console.error(error);
  wait(`The meshes cannot be shown: ${error.message}. The numbers are complete. A browser of 2023 or newer with WebGL is needed.`);
}

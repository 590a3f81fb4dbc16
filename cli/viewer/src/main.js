// The page of `neural-mesh compare`: reads what the program wrote into it and wires up view, switches and numbers.

import { makeBar } from './bar.js';
import { fillCaption } from './caption.js';
import { listen } from './keys.js';
import { makeScene, placeOf, setColourEnd, setSceneTheme, setSwitches, showResult } from './scene.js';
import { fillMeanings, fillTable, showColumn } from './table.js';
import { makeTheme } from './theme.js';
import { lookFromStart, makeView } from './view.js';
import { count } from './words.js';

const at = (id) => document.getElementById(id);

function start() {
  const data = JSON.parse(at('comparison').textContent);
  const { comparison, surfaces, covers, scale, eye } = data;
  writeWords(comparison);
  const panes = [at('pane-0'), at('pane-1')];
  const place = placeOf(surfaces, eye);
  const view = makeView(at('canvas'), panes, place);
  const scene = makeScene(view, data, place);
  view.drawn = () => { if (scene.models.length > 0) markFirstDraw(); };
  makeTheme((colours) => setSceneTheme(scene, colours));
  makeBar(scale, Math.hypot(...surfaces[0].sides), (share) => setColourEnd(scene, share));
  listen(view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(view));
  wireTexture(covers);
  wireSwitches(scene);
  wireSlider(scene, comparison, data, panes);
}

function writeWords({ original, results, settings, program, figures, left_out: leftOut }) {
  at('name').textContent = original.name;
  at('how-many').textContent = results.length === 1 ? 'and one simplified mesh' : `and ${results.length} simplified meshes`;
  fillTable(at('figures'), { figures, results });
  fillMeanings(at('meanings'), figures);
  at('settings').textContent = `${program}, ${count(settings.samples)} samples on each surface, seed ${settings.seed}`
    + (leftOut ? `; left out: ${leftOut}` : '');
}

/** Shows the switch of textures where a mesh has one; a surface has one kind of colours at a time. */
function wireTexture(covers) {
  const [texture, colours] = [at('texture'), at('colours')];
  texture.disabled = covers.every((cover) => !cover);
  texture.parentElement.hidden = texture.disabled;
  texture.addEventListener('change', () => { if (texture.checked) colours.checked = false; });
  colours.addEventListener('change', () => { if (colours.checked) texture.checked = false; });
}

/** What a caption says of the cover of a mesh, where textures are shown. */
function wordsOfCover(cover) {
  if (!cover) return 'no texture, no colours: plain';
  return cover.borrowed ? 'texture of the original' : '';
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
}

function wireSlider(scene, { original, results }, { surfaces, covers }, panes) {
  const slider = at('result');
  slider.max = results.length;
  at('results').hidden = results.length === 1;
  fillCaption(panes[0], 'Original', original, surfaces[0].marked, wordsOfCover(covers[0]));
  const show = async () => {
    const index = slider.valueAsNumber;
    const { name } = results[index - 1];
    slider.setAttribute('aria-valuetext', name);
    at('which').textContent = `${name} (${index} of ${results.length})`;
    fillCaption(panes[1], 'Simplified', results[index - 1], surfaces[index].marked, wordsOfCover(covers[index]));
    showColumn(at('figures'), index - 1);
    wait('Unpacking the meshes');
    if (await showResult(scene, index)) {
      wait('');
      document.documentElement.dataset.result = index;
    }
  };
  slider.addEventListener('input', () => attempt(show()));
  at('previous').addEventListener('click', () => step(slider, -1));
  at('next').addEventListener('click', () => step(slider, 1));
  attempt(show());
}

function step(slider, by) {
  slider.value = slider.valueAsNumber + by;
  slider.dispatchEvent(new Event('input'));
}

function wait(words) {
  at('wait').textContent = words;
  at('wait').hidden = words === '';
}

function markFirstDraw() {
  if (document.documentElement.dataset.state === 'ready') return;
  document.documentElement.dataset.state = 'ready';
  performance.mark('first-draw');
}

/** What goes wrong is said in the page. */
function attempt(work) {
  return work.catch(fail);
}

function fail(error) {
  console.error(error);
  wait(`The meshes cannot be shown: ${error.message}. The numbers are complete. A browser of 2023 or newer with WebGL is needed.`);
}

try {
  start();
} catch (error) {
  fail(error);
}

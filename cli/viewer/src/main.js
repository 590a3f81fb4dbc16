// The page of `neural-mesh compare`: reads the data that the program wrote into it, and wires up view, switches and numbers.

import { makeBar } from './bar.js';
import { fillCaption } from './caption.js';
import { GRADIENT } from './colours.js';
import { drawFlip } from './flip.js';
import { fillHeadline } from './headline.js';
import { packedSource } from './packed.js';
import { makeScene, placeOf, setColourEnd, setSceneTheme, showPair } from './scene.js';
import { attempt, fail, markFirstDraw, offerTexture, wait, wireStage } from './stage.js';
import { fillMeanings, fillTable, showColumn } from './table.js';
import { makeTheme } from './theme.js';
import { makeView } from './view.js';
import { wireWipe } from './wipe.js';
import { count } from './words.js';

const at = (id) => document.getElementById(id);

function start() {
  const data = JSON.parse(at('comparison').textContent);
  const { comparison, surfaces, covers, scale, eye } = data;
  writeWords(comparison);
  const panes = [at('pane-0'), at('pane-1')];
  const place = placeOf(surfaces, eye);
  const view = makeView(at('canvas'), panes, place);
  const pairs = comparison.results.map((_, i) => ({ original: 0, result: i + 1, distances: `distances-${i + 1}` }));
  const scene = makeScene(view, { source: packedSource(data), pairs, places: [place] });
  view.drawn = () => { if (scene.models.length > 0) markFirstDraw(); };
  makeTheme((colours) => setSceneTheme(scene, colours));
  makeBar((share) => setColourEnd(scene, share))(scale, Math.hypot(...surfaces[0].sides));
  offerTexture(covers.some(Boolean));
  at('texture').checked = covers.some(Boolean);
  wireStage(scene);
  wireWipe(view);
  wireSlider(scene, comparison, data, panes);
}

function writeWords(comparison) {
  at('flip-gradient').style.background = GRADIENT;
  const { original, results, settings, program, figures } = comparison;
  at('name').textContent = original.name;
  at('how-many').textContent = results.length === 1 ? 'and one simplified mesh' : `and ${results.length} simplified meshes`;
  fillTable(at('figures'), comparison);
  fillMeanings(at('meanings'), figures);
  at('settings').textContent = `${program}, ${count(settings.samples)} samples on each surface, seed ${settings.seed}`;
}

/** Returns the words of a caption about the texture of a mesh, if textures are shown. */
function wordsOfCover(cover) {
  if (!cover) return 'plain: no texture and no colours';
  return cover.borrowed ? 'texture of the original' : '';
}

function wireSlider(scene, { original, results }, { surfaces, covers, flip }, panes) {
  const slider = at('result');
  slider.max = results.length;
  slider.value = 1;
  at('results').hidden = results.length === 1;
  fillCaption(panes[0], 'Original', original, surfaces[0].marked, wordsOfCover(covers[0]));
  const show = async () => {
    const index = slider.valueAsNumber;
    const { name } = results[index - 1];
    slider.setAttribute('aria-valuetext', name);
    at('which').textContent = `${index} of ${results.length}: ${name}`;
    fillCaption(panes[1], 'Simplified', results[index - 1], surfaces[index].marked, wordsOfCover(covers[index]));
    fillHeadline(at('headline'), original, results[index - 1]);
    showColumn(at('figures'), index - 1);
    at('flip').hidden = flip[index - 1].length === 0;
    if (!at('flip').hidden) attempt(drawFlip(at('flip-map'), `flip-${index}`, flip[index - 1]));
    wait('Unpacking the meshes');
    if (await showPair(scene, index - 1)) {
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

try {
  start();
} catch (error) {
  fail(error);
}

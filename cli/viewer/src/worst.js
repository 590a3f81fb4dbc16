// The worst cases of the methods: a table, and the meshes of the chosen case.

import { makeBar } from './bar.js';
import { fillCaption } from './caption.js';
import { packedSource } from './packed.js';
import { makeScene, placeOf, setColourEnd, setSceneTheme, showPair } from './scene.js';
import { fillSorted } from './sorted.js';
import { attempt, markFirstDraw, offerTexture, wait, wireStage } from './stage.js';
import { makeView } from './view.js';
import { precise } from './words.js';

const DIGITS = 3;

const at = (id) => document.getElementById(id);

/** Fills the table and creates the view; does nothing without cases. */
export function makeWorst({ overview: { methods }, worst: cases, surfaces, eyes }) {
  // Sorted by method; the cases of a method already come with the worst first.
  const worst = methods.flatMap((method) => cases.filter((one) => one.method === method));
  at('worst-section').hidden = worst.length === 0;
  if (worst.length === 0) return null;
  const shown = worst.filter((one) => one.shown);
  at('how-worst').textContent = 'For each method, the three cases in which its mean distance exceeds the best other method most.'
    + (shown.length < worst.length ? ' Meshes without a button are too large for this page.' : '');
  at('meshes').hidden = shown.length === 0;
  const show = shown.length > 0 ? makeMeshes(shown, surfaces, eyes) : null;
  fillTable(worst, (one) => attempt(show.show(shown.indexOf(one))));
  return show ? { setTheme: show.setTheme, start: () => attempt(show.show(0)) } : { setTheme: () => {}, start: async () => markFirstDraw() };
}

function fillTable(worst, choose) {
  const hasSeeds = new Set(worst.map(({ seed }) => seed)).size > 1;
  const columns = [
    { title: 'method', isWord: true }, { title: 'mesh', isWord: true }, { title: 'ratio' }, ...(hasSeeds ? [{ title: 'seed' }] : []),
    { title: 'distance', unit: '%', about: 'mean distance, in percent of the diagonal' },
    { title: '× best other', about: 'mean distance divided by the best mean distance of another method' },
  ];
  const rows = worst.map((one) => [
    { value: one.method, text: one.method },
    { value: one.mesh, ...(one.shown ? { element: button(one, choose) } : { text: one.mesh }) },
    { value: one.ratio, text: String(one.ratio) },
    ...(hasSeeds ? [{ value: one.seed, text: String(one.seed) }] : []),
    { value: one.distance, text: precise(one.distance, DIGITS) },
    { value: one.quotient, text: one.quotient === null ? '' : precise(one.quotient, DIGITS) },
  ]);
  fillSorted(at('worst'), columns, rows);
}

function button(one, choose) {
  const element = Object.assign(document.createElement('button'), { type: 'button', className: 'open', textContent: one.mesh });
  one.button = element;
  element.addEventListener('click', () => choose(one));
  return element;
}

/** Creates the view of the cases that have meshes. */
function makeMeshes(cases, surfaces, eyes) {
  const pairs = cases.map(({ shown }) => shown);
  const places = placesOf(pairs, surfaces, eyes);
  const panes = [at('pane-0'), at('pane-1')];
  const view = makeView(at('canvas'), panes, places[pairs[0].original]);
  const source = packedSource({ surfaces, covers: surfaces.map(() => null), images: [] });
  const scene = makeScene(view, { source, pairs, places });
  view.drawn = () => { if (scene.models.length > 0) markFirstDraw(); };
  const showScale = makeBar((share) => setColourEnd(scene, share));
  offerTexture(false);
  wireStage(scene);
  const show = async (index) => {
    const { method, mesh, ratio, shown: { original, result, scale } } = cases[index];
    cases.forEach(({ button: other }, i) => { if (other) other.ariaPressed = String(i === index); });
    fillCaption(panes[0], 'Original', { name: mesh, faces: surfaces[original].faces }, surfaces[original].marked, '');
    fillCaption(panes[1], method, { name: `at ratio ${ratio}`, faces: surfaces[result].faces }, surfaces[result].marked, '');
    wait('Unpacking the meshes');
    if (await showPair(scene, index)) {
      showScale(scale, Math.hypot(...surfaces[original].sides));
      wait('');
      document.documentElement.dataset.result = index;
    }
  };
  return { show, setTheme: (colours) => setSceneTheme(scene, colours) };
}

/** Returns the placement of each original and its results. */
function placesOf(pairs, surfaces, eyes) {
  const places = [];
  for (const { original } of pairs) {
    const results = pairs.filter((pair) => pair.original === original).map(({ result }) => surfaces[result]);
    places[original] ??= placeOf([surfaces[original], ...results], eyes[original]);
  }
  return places;
}

// The page of `neural-mesh clusters`: shows the hierarchy that the program wrote into it, or one that the reader opens or drops.

import { element } from '../element.js';
import { wireFlight } from '../fly.js';
import { listen } from '../keys.js';
import { makeOpener, markOpened, openEmbedded } from '../opener.js';
import { BOX, turnUp } from '../single.js';
import { wait } from '../stage.js';
import { makeTheme } from '../theme.js';
import { askToDraw, lookFromStart, makeView } from '../view.js';
import { count } from '../words.js';
import { readHierarchy } from './container.js';
import { LEVEL_COLOURS, SIZE_COLOURS } from './material.js';
import { loadPaints } from './paints.js';
import { makeRates, noteFrame, ratesOf } from './rates.js';
import { isSettled, makeClusterScene, setClusterTheme, trianglesOf } from './scene.js';

const at = (id) => document.getElementById(id);

/** Milliseconds between updates of the figures. */
const EVERY = 250;

const WORDS = {
  command: 'clusters',
  loading: 'Loading the coarsest level',
  empty: 'Choose or drop a file .nmc, which neural-mesh clusters writes',
};

function start() {
  const view = makeView(at('canvas'), [at('pane-0')], BOX);
  const page = {
    view, scene: null, rates: makeRates(), theme: null, opener: null,
    settings: { pixels: 1, colouring: 'clusters', isFrozen: false, zUp: false, turns: false },
  };
  view.controls.zoomToCursor = true;
  view.drawn = () => drawn(page);
  makeTheme((theme) => {
    page.theme = theme;
    view.renderer.setClearColor(theme.stage);
    if (page.scene) setClusterTheme(page.scene, theme);
    askToDraw(view);
  });
  listen(view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(view));
  wireFlight(view, at('fly'));
  wireSettings(page);
  setInterval(() => writeFigures(page), EVERY);
  at('canvas').drawnTriangles = () => Float32Array.from(trianglesOf(page.scene));
  page.opener = makeOpener({
    words: WORDS, show: (content, refuse) => show(page, content, refuse),
    read: async (file, facts) => ({ hierarchy: await readHierarchy(file), paints: await loadPaints(facts) }),
  });
  openEmbedded(page.opener);
}

function show(page, { hierarchy, paints }, refuse) {
  const { view, settings } = page;
  offerTexture(settings, paints.hasTextures);
  page.scene = makeClusterScene(view, hierarchy, settings, { before: page.scene, failed: refuse, paints });
  setClusterTheme(page.scene, page.theme);
  turnUp(page.scene, settings.zUp);
}

/** Shows the choice of textures if the file has some. */
function offerTexture(settings, isThere) {
  const choice = at('texture');
  choice.disabled = !isThere;
  choice.parentElement.hidden = !isThere;
  if (isThere || !choice.checked) return;
  document.querySelector('[name="colouring"][value="clusters"]').checked = true;
  settings.colouring = 'clusters';
}

function wireSettings(page) {
  const { settings, view } = page;
  const slider = at('pixels');
  const update = () => {
    settings.pixels = 2 ** slider.valueAsNumber;
    const words = `${settings.pixels < 10 ? Number(settings.pixels.toPrecision(2)) : Math.round(settings.pixels)} px`;
    at('how-many-pixels').textContent = words;
    slider.setAttribute('aria-valuetext', words);
    for (const box of document.querySelectorAll('[data-switch]')) settings[box.dataset.switch] = box.checked;
    settings.colouring = document.querySelector('[name="colouring"]:checked').value;
    for (const legend of document.querySelectorAll('[data-legend]')) legend.hidden = legend.dataset.legend !== settings.colouring;
    view.controls.autoRotate = settings.turns;
    if (page.scene) turnUp(page.scene, settings.zUp);
    askToDraw(view);
  };
  const step = (by) => {
    slider.value = slider.valueAsNumber + by;
    update();
  };
  at('finer').addEventListener('click', () => step(-1));
  at('coarser').addEventListener('click', () => step(1));
  slider.addEventListener('input', update);
  document.querySelectorAll('[data-switch], [name="colouring"]').forEach((box) => box.addEventListener('change', update));
  at('sizes-gradient').style.background = `linear-gradient(to right, ${SIZE_COLOURS.join(', ')})`;
  update();
}

/** Follows a drawn frame: counts it, and goes on while the view turns. */
function drawn(page) {
  const { scene, view, settings, rates } = page;
  if (!scene?.isPlaced) return;
  const { cut } = scene;
  noteFrame(rates, performance.now(), view.renderer.info.render.triangles);
  // A turned camera asks for the next frame.
  if (settings.turns) view.controls.update();
  markOpened(page.opener);
  // Signals to tests that the cut is complete.
  document.documentElement.dataset.cut = isSettled(scene) ? `${cut.nTriangles}` : '';
}

function writeFigures({ scene, rates }) {
  if (!scene?.isPlaced) return;
  const { cut, store } = scene;
  const { triangles, perSecond } = ratesOf(rates, performance.now());
  const figures = {
    drawn: count(triangles), cut: count(cut.nTriangles), clusters: `${count(cut.nClusters)} of ${count(scene.hierarchy.clusters.n)}`,
    pages: `${count(store.nLoaded)} of ${count(store.states.length)}`,
    frames: perSecond === null ? 'at rest' : count(perSecond),
    rate: perSecond === null ? 'at rest' : `${(perSecond * triangles / 1e6).toPrecision(3)} million`,
  };
  for (const [id, text] of Object.entries(figures)) at(`figure-${id}`).textContent = text;
  at('levels').replaceChildren(...cut.ofLevels.map(levelRow).filter(Boolean));
}

function levelRow(sums, level) {
  const row = document.createElement('tr');
  const swatch = element('span', '', { className: 'swatch' });
  swatch.style.background = LEVEL_COLOURS[level % LEVEL_COLOURS.length];
  const head = element('th', `${level} `, { scope: 'row' });
  head.prepend(swatch);
  row.append(head, element('td', count(sums.nClusters)), element('td', count(sums.nTriangles)));
  return row;
}

try {
  start();
} catch (error) {
  console.error(error);
  wait(`The hierarchy cannot be shown: ${error.message}. A browser of 2023 or newer with WebGL is needed.`);
}

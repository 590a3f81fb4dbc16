// The page of `neural-mesh clusters`: shows the hierarchy that the program wrote into it, or one that the reader opens or drops.

import { element } from '../element.js';
import { listen } from '../keys.js';
import { bytesOf } from '../numbers.js';
import { attempt, markFirstDraw, wait } from '../stage.js';
import { makeTheme } from '../theme.js';
import { askToDraw, lookFromStart, makeView } from '../view.js';
import { count } from '../words.js';
import { readHierarchy } from './container.js';
import { LEVEL_COLOURS, SIZE_COLOURS } from './material.js';
import { makeRates, noteFrame, ratesOf } from './rates.js';
import { isSettled, makeClusterScene, setClusterTheme, trianglesOf, turnScene } from './scene.js';

const at = (id) => document.getElementById(id);

/** Milliseconds between updates of the figures. */
const EVERY = 250;

const BOX = { half: [0.58, 0.58, 0.58], radius: 1, eye: [0.55, 0.4, 1] };

function start() {
  const view = makeView(at('canvas'), [at('pane-0')], BOX);
  const page = {
    view, scene: null, rates: makeRates(), theme: null, nOpened: 0, isOpening: false,
    settings: { pixels: 1, colouring: 'clusters', isFrozen: false, zUp: false, turns: false },
  };
  view.drawn = () => drawn(page);
  makeTheme((theme) => {
    page.theme = theme;
    view.renderer.setClearColor(theme.stage);
    if (page.scene) setClusterTheme(page.scene, theme);
    askToDraw(view);
  });
  listen(view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(view));
  wireSettings(page);
  wireFiles(page);
  setInterval(() => writeFigures(page), EVERY);
  at('canvas').drawnTriangles = () => Float32Array.from(trianglesOf(page.scene));
  openEmbedded(page);
}

/** Opens the hierarchy in the page, if there is one. */
function openEmbedded(page) {
  const words = at('hierarchy');
  if (!words) {
    wait('Choose or drop a file .nmc, which neural-mesh clusters writes');
    markFirstDraw();
    return;
  }
  const { name } = JSON.parse(words.textContent);
  open(page, name, async () => {
    const stream = new Blob(await bytesOf('clusters')).stream().pipeThrough(new DecompressionStream('deflate-raw'));
    return new Response(stream).blob();
  });
}

/** Opens a file; a later call replaces this one. One line says why a file, or a page of it, cannot be shown. */
async function open(page, name, load) {
  const turn = ++page.nOpened;
  const refuse = (error) => {
    if (turn !== page.nOpened) return;
    page.isOpening = false;
    wait(`${name}: ${error.message}`);
  };
  page.isOpening = true;
  wait('Loading the coarsest level');
  try {
    const hierarchy = await readHierarchy(await load());
    if (turn !== page.nOpened) return;
    page.scene = makeClusterScene(page.view, hierarchy, page.settings, { before: page.scene, failed: refuse });
    setClusterTheme(page.scene, page.theme);
    turnScene(page.scene);
    at('name').textContent = name;
    document.title = `${name} - neural-mesh clusters`;
  } catch (error) {
    refuse(error);
  }
}

function wireFiles(page) {
  const openFile = (file) => { if (file) attempt(open(page, file.name, async () => file)); };
  at('file').addEventListener('change', () => openFile(at('file').files[0]));
  at('choose').addEventListener('click', () => at('file').click());
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    openFile(event.dataTransfer.files[0]);
  });
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
    if (page.scene) turnScene(page.scene);
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
  if (page.isOpening) {
    page.isOpening = false;
    wait('');
    markFirstDraw();
  }
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

// The page of `neural-mesh progression`: shows levels of the progression that the program wrote into it, or of one that the reader
// opens or drops.

import { element } from '../element.js';
import { wireFlight } from '../fly.js';
import { listen } from '../keys.js';
import { makeOpener, markOpened, openEmbedded } from '../opener.js';
import { BOX, turnUp } from '../single.js';
import { attempt, wait } from '../stage.js';
import { makeTheme } from '../theme.js';
import { askToDraw, lookFromStart, makeView } from '../view.js';
import { count, short } from '../words.js';
import { exportLevel } from './exported.js';
import { FORMATS } from './formats.js';
import { findLevel, openProgression } from './level.js';
import { makeProgressionScene, setProgressionTheme, trianglesOf } from './scene.js';
import { breathe } from '../slices.js';
import { PER_HALVING, sizesBetween } from './sizes.js';

const at = (id) => document.getElementById(id);

const WORDS = {
  command: 'progression',
  loading: 'Reading the progression',
  empty: 'Choose or drop a file .nmp, which neural-mesh progression writes',
};

function start() {
  const view = makeView(at('canvas'), [at('pane-0')], BOX);
  const page = {
    view, scene: null, theme: null, opener: null, sizes: [0], proofs: [], written: null,
    settings: { size: Infinity, wire: false, flat: true, zUp: false, turns: false },
  };
  view.controls.zoomToCursor = true;
  view.drawn = () => drawn(page);
  makeTheme((theme) => {
    page.theme = theme;
    view.renderer.setClearColor(theme.stage);
    if (page.scene) setProgressionTheme(page.scene, theme);
    askToDraw(view);
  });
  listen(view, at('canvas'));
  at('reset').addEventListener('click', () => lookFromStart(view));
  wireSwitches(page);
  wireSlider(page);
  wireFly(page);
  at('save').addEventListener('click', () => attempt(save(page)));
  at('canvas').drawnTriangles = () => Float32Array.from(trianglesOf(page.scene));
  page.opener = makeOpener({ words: WORDS, read: openProgression, show: (progression) => show(page, progression) });
  openEmbedded(page.opener);
}

function show(page, progression) {
  const { view, settings } = page;
  at('flat').checked = !progression.hasNormals;
  readSwitches(settings);
  page.scene = makeProgressionScene(view, progression, settings, page.scene);
  setProgressionTheme(page.scene, page.theme);
  turnUp(page.scene, settings.zUp);
  const smallest = findLevel(progression, { vertices: 1, faces: Infinity });
  page.proofs = progression.proofs.map((proof) => ({
    ...proof, level: findLevel(progression, { vertices: proof.nVertices, faces: Infinity }),
  }));
  page.sizes = sizesBetween(smallest.nVertices, progression.size[0], progression.proofs);
  at('size').max = page.sizes.length - 1;
  listProofs(page);
  at('dropped-row').hidden = progression.drops.length === 0;
  moveTo(page, page.sizes.length - 1);
}

/** Shows the level at a step of the slider. */
function moveTo(page, step) {
  const slider = at('size');
  slider.value = step;
  page.settings.size = page.sizes[slider.valueAsNumber];
  askToDraw(page.view);
}

function wireSlider(page) {
  const slider = at('size');
  slider.addEventListener('input', () => moveTo(page, slider.valueAsNumber));
  at('fewer').addEventListener('click', () => moveTo(page, slider.valueAsNumber - PER_HALVING));
  at('more').addEventListener('click', () => moveTo(page, slider.valueAsNumber + PER_HALVING));
}

/** Makes the level fall as the camera flies away, so that triangles stay as large on the screen. */
function wireFly(page) {
  wireFlight(page.view, at('fly'), () => {
    const first = at('size').valueAsNumber;
    return (factor) => moveTo(page, first - Math.round(2 * PER_HALVING * Math.log2(factor)));
  });
}

/** Saves the level that is shown, in the chosen format. */
async function save({ scene }) {
  if (!scene?.level) return;
  const { level, progression } = scene;
  wait('Making the file');
  await breathe();
  const format = at('format').value;
  const file = FORMATS[format](exportLevel(progression, level));
  wait('');
  const name = at('name').textContent.replace(/\.\w+$/, '');
  const link = element('a', '', { href: URL.createObjectURL(file), download: `${name}-${level.nFaces}.${format}` });
  link.click();
  // The browser reads the file after the click.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

function wireSwitches(page) {
  const { view, settings } = page;
  const update = () => {
    readSwitches(settings);
    view.controls.autoRotate = settings.turns;
    if (page.scene) turnUp(page.scene, settings.zUp);
    askToDraw(view);
  };
  for (const box of document.querySelectorAll('[data-switch]')) box.addEventListener('change', update);
  update();
}

function readSwitches(settings) {
  for (const box of document.querySelectorAll('[data-switch]')) settings[box.dataset.switch] = box.checked;
}

/** Follows a drawn frame: writes its figures, and goes on while the view turns. */
function drawn(page) {
  const { scene, view, settings } = page;
  if (!scene?.level) return;
  markOpened(page.opener);
  // A turned camera asks for the next frame.
  if (settings.turns) view.controls.update();
  if (page.written === scene.level) return;
  page.written = scene.level;
  writeFigures(page);
  // Signals to tests which level is drawn.
  document.documentElement.dataset.level = scene.level.nFaces;
}

function writeFigures({ scene: { level, progression }, proofs }) {
  const proof = proofs.find((other) => isSame(other.level, level));
  const nDropped = progression.drops.slice(0, level.nDrops).reduce((sum, { components }) => sum + components.length, 0);
  const figures = {
    faces: count(level.nFaces), vertices: count(level.nVertices),
    share: `${short((100 * level.nFaces) / progression.size[1])} %`,
    distance: distanceWords(level, proof, progression), dropped: count(nDropped),
  };
  for (const [id, text] of Object.entries(figures)) at(`figure-${id}`).textContent = text;
  at('how-many').textContent = `${figures.faces} faces`;
  at('size').setAttribute('aria-valuetext', `${figures.faces} faces`);
  for (const row of at('proofs').rows) row.classList.toggle('shown', Number(row.dataset.size) === proof?.nVertices);
}

function isSame(one, other) {
  return one.n === other.n && one.nDrops === other.nDrops;
}

function distanceWords(level, proof, { proofs, diagonal }) {
  if (level.isWhole) return '0';
  if (proof) return `${short(proof.distance)}, ${shareWords(proof.distance, diagonal)}`;
  return proofs.length > 0 ? 'only at the sizes below' : 'none without --prove';
}

function shareWords(distance, diagonal) {
  return diagonal > 0 ? `${short((100 * distance) / diagonal)} %` : '';
}

/** Lists the proved levels, each with a button that shows it. */
function listProofs(page) {
  const { diagonal } = page.scene.progression;
  at('proofs').replaceChildren(...page.proofs.map((proof) => {
    const row = document.createElement('tr');
    row.dataset.size = proof.nVertices;
    const button = element('button', `${count(proof.level.nFaces)} faces`, { type: 'button', title: 'Shows this level' });
    button.addEventListener('click', () => moveTo(page, page.sizes.indexOf(proof.nVertices)));
    const head = element('th', '', { scope: 'row' });
    head.append(button);
    row.append(head, element('td', short(proof.distance)), element('td', shareWords(proof.distance, diagonal)));
    return row;
  }));
  at('proved-steps').replaceChildren(...page.proofs.map((proof) => element('option', '', { value: page.sizes.indexOf(proof.nVertices) })));
  at('proof-table').hidden = page.proofs.length === 0;
}

try {
  start();
} catch (error) {
  console.error(error);
  wait(`The progression cannot be shown: ${error.message}. A browser of 2023 or newer with WebGL is needed.`);
}

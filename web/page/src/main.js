// The page: opens a mesh, shows simplified ones next to it, and saves them. Everything runs in the browser.

import { makeBar } from '../../../cli/viewer/src/bar.js';
import { fillCaption } from '../../../cli/viewer/src/caption.js';
import { fillHeadline } from '../../../cli/viewer/src/headline.js';
import {
  drawThumbnail, dropPair, makeScene, placeOf, refreshShares, setColourEnd, setContent, setSceneTheme, showPair, warmUp,
} from '../../../cli/viewer/src/scene.js';
import { markFirstDraw, offerTexture, wait, wireStage } from '../../../cli/viewer/src/stage.js';
import { makeTheme } from '../../../cli/viewer/src/theme.js';
import { spokenBytes } from '../../../cli/viewer/src/verdicts.js';
import { makeView } from '../../../cli/viewer/src/view.js';
import { wireWipe } from '../../../cli/viewer/src/wipe.js';
import { listFormats, warmUpEngine } from './engine.js';
import { makeSmallGear } from './examples.js';
import { endingOf, meshesAmong, readMesh } from './files.js';
import { cancel, makeJobs } from './jobs.js';
import { levelCanvas, makeDownloads, makeLevels, showChosen, showDownloads, showFigures, showLevels, showNotes, showRecipes } from './panel.js';
import { attempt, oneLine, showWork, warn } from './status.js';
import { COLOURS, convert, forget, makeSession, measure, NOW, outdatedResults, prepareLevels, readSession, resultOf } from './session.js';
import { percent, placeOfShare, readOptions, readWish, shareAt } from './sizes.js';
import { makeSource } from './surfaces.js';
import { save, sizeOf } from './save.js';
import { wireDoors, wireSizes } from './wiring.js';

/** Direction from which a mesh is first seen whose most telling side is not known. */
const EYE = [0.5, 0.3, 0.82];
/** Corners of faces of a level above which it has no thumbnail, as making one takes as long as showing it. */
const MOST_CORNERS = 3e6;
/** Formats whose up axis is z by convention. */
const Z_UP = ['stl', '3mf'];

const at = (id) => document.getElementById(id);
const panes = [at('pane-0'), at('pane-1')];

function start() {
  const app = { session: null, idle: '' };
  app.jobs = makeJobs((job) => {
    if (job) app.idle = '';
    showWork(job, app.idle);
  });
  makeStage(app);
  makeLevels((share) => { wireShare(share); attempt(fulfil(app)); });
  wireDoors((files) => attempt(open(app, files)), (make) => attempt(openFile(app, make())));
  wireSizes({ drag: () => showNearest(app), settle: () => attempt(fulfil(app)) });
  at('cancel').addEventListener('click', () => stop(app));
  wireShare(0.1);
  showWork(null, '');
  setOpen(false);
  app.endings = listFormats();
  // Nobody waits for what fails there.
  app.endings.then(() => warmUpEngine(makeSmallGear())).catch(() => {});
  attempt(app.endings.then((endings) => makeDownloads(endings, (ending) => attempt(download(app, ending)))));
}

/** Creates the empty view and its switches. */
function makeStage(app) {
  const place = placeOf([{ low: [-1, -1, -1], sides: [2, 2, 2] }], EYE);
  const view = makeView(at('canvas'), panes, place);
  const source = makeSource(() => null);
  app.scene = makeScene(view, { source, pairs: [{ original: 0 }], places: [place] });
  view.drawn = () => {
    markFirstDraw();
    view.drawn = null;
    setTimeout(warmUp, 0, app.scene);
  };
  makeTheme((colours) => setSceneTheme(app.scene, colours));
  app.showScale = makeBar((share) => setColourEnd(app.scene, share));
  offerTexture(false);
  app.applySwitches = wireStage(app.scene);
  wireWipe(view);
  wait('');
  // Both switches need distances, which are otherwise measured last.
  const hurry = ({ target }) => { if (target.checked) attempt(measureShown(app, COLOURS)); };
  for (const name of ['colours', 'farthest']) document.querySelector(`[data-switch="${name}"]`).addEventListener('change', hurry);
}

/** Opens the first mesh among files; the others can be chosen. */
async function open(app, files) {
  const meshes = meshesAmong(files);
  if (meshes.length === 0) {
    const none = 'None of these files is a mesh: choose OBJ, PLY, STL, OFF, glTF, GLB or 3MF.';
    warn(files.length === 0 ? 'You dropped no file: drop a mesh file or a folder.' : none);
    return;
  }
  at('others').hidden = meshes.length === 1;
  at('meshes').replaceChildren(...meshes.map(({ path }, i) => new Option(path, i)));
  const openAt = async (i) => openFile(app, await readMesh(meshes[i], files));
  at('meshes').onchange = () => attempt(openAt(at('meshes').value));
  await openAt(0);
}

/** Opens a file; if it cannot be read, the open mesh stays. */
async function openFile(app, file) {
  warn('');
  performance.mark('opened');
  cancel(app.jobs);
  const own = endingOf(file.name);
  const session = makeSession(file, (await app.endings).includes(own) ? own : 'glb');
  app.opening = session;
  try {
    await readSession(app.jobs, session);
  } catch (error) {
    if (app.opening === session && app.session) attempt(fulfil(app));
    throw error;
  }
  if (app.opening !== session) return;
  app.session = session;
  // Work on the previous mesh may have queued more jobs meanwhile.
  cancel(app.jobs, ({ owner }) => owner !== session);
  await showOriginal(app);
  await fulfil(app);
}

async function showOriginal(app) {
  const { session } = app;
  const source = makeSource(({ key }) => session.results.get(key)?.shares ?? null);
  const isZUp = Z_UP.includes(endingOf(session.file.name));
  // The most telling side is found as if y were up.
  const place = placeOf([source.boxOf(source.add(session.mesh))], isZUp ? EYE : session.mesh.eye ?? EYE);
  Object.assign(session, { source, place });
  setContent(app.scene, { source, pairs: [{ original: 0 }], places: [place] });
  setOpen(true);
  at('name').textContent = session.file.name;
  document.title = `${session.file.name} - neural-mesh`;
  at('faces').value = Math.max(Math.round(session.mesh.faces.length / 30), 1);
  fillCaption(panes[0], 'Original', captionOf(session.file, session.mesh));
  panes[1].querySelector('.caption').replaceChildren();
  at('headline').replaceChildren();
  showLevels(session, readOptions());
  showDownloads(session);
  showNotes(session);
  for (const name of ['texture', 'zUp']) {
    const box = document.querySelector(`[data-switch="${name}"]`);
    box.checked = name === 'zUp' ? isZUp : source.hasCover(0);
    if (name === 'texture' && box.checked) at('colours').checked = false;
  }
  offerTexture(source.hasCover(0));
  app.applySwitches();
  await showPair(app.scene, 0);
  performance.mark('original-shown');
}

function captionOf(file, mesh) {
  return { name: `${file.name}, ${spokenBytes(sizeOf(file))}`, faces: mesh.faces.length / 3 };
}

/** Makes and shows the chosen result, then the levels, then the figures. */
async function fulfil(app) {
  const { session } = app;
  if (!session) return;
  const { wish, why } = readWish();
  if (!wish) return warn(why);
  warn('');
  if (session.wanted !== wish.key) forget(app.jobs, session.wanted);
  session.wanted = wish.key;
  const result = await resultOf(app.jobs, session, wish, NOW);
  if (app.session !== session || session.wanted !== wish.key) return;
  await show(app, result);
  // The headline waits for the figures, so they come before the other levels.
  const measuring = measureShown(app, COLOURS);
  prepareLevels(app.jobs, session, wish.options, () => { if (app.session === session) attempt(showMade(app)); });
  await measuring;
}

/** The result that each thumbnail shows. */
const drawn = new WeakMap();

/** Shows the levels that exist, each with a thumbnail. */
async function showMade(app) {
  const { session, scene } = app;
  const options = readOptions();
  showLevels(session, options);
  for (const result of session.results.values()) {
    const canvas = levelCanvas(result, options);
    if (!canvas || drawn.get(canvas) === result || result.mesh.faces.length > MOST_CORNERS) continue;
    drawn.set(canvas, result);
    if (result.pair === undefined) addPair(app, result);
    await drawThumbnail(scene, result.pair, canvas);
    if (app.session !== session) return;
  }
}

/** Shows a result next to the original. */
async function show(app, result) {
  const { session, scene } = app;
  if (session.shown === result) return;
  session.shown = result;
  if (result.pair === undefined) addPair(app, result);
  fillCaption(panes[1], 'Lighter', captionOf(result.file, result.mesh));
  showBeside(app);
  attempt(showMade(app));
  if (result.scale) showScaleOf(app, result);
  if (await showPair(scene, result.pair)) {
    document.documentElement.dataset.shown = result.wish.title;
    performance.mark('result-shown');
  }
}

/** Adds a result to the scene, and removes the oldest ones if there are too many. */
function addPair({ session, scene }, result) {
  scene.pairs.push({ original: 0, result: session.source.add(result.mesh), key: result.wish.key });
  result.pair = scene.pairs.length - 1;
  for (const { pair } of outdatedResults(session)) {
    if (pair === undefined) continue;
    dropPair(scene, pair);
    session.source.remove(scene.pairs[pair].result);
  }
}

/** Updates the panel next to the view. */
function showBeside({ session }) {
  const options = readOptions();
  showLevels(session, options);
  showChosen(options);
  showDownloads(session);
  showFigures(session);
  sayHeadline(session);
  showRecipes(session);
  showNotes(session);
}

/** Shows the nearest existing result while the slider moves. */
function showNearest(app) {
  const share = shareAt(at('share').valueAsNumber);
  wireShare(share, false);
  const { session } = app;
  if (!session) return;
  const options = JSON.stringify(readOptions());
  const ready = [...session.results.values()].filter(({ wish }) => wish.size.ratio && JSON.stringify(wish.options) === options);
  const far = ({ wish }) => Math.abs(Math.log(wish.size.ratio / share));
  const nearest = ready.reduce((best, other) => (best && far(best) <= far(other) ? best : other), null);
  if (nearest) attempt(show(app, nearest));
}

/** Shows the chosen share. */
function wireShare(share, moves = true) {
  if (moves) at('share').value = placeOfShare(share);
  at('share').setAttribute('aria-valuetext', percent(share));
  at('share-is').textContent = percent(share);
}

/** Measures the shown result, and shows its figures and colours. */
async function measureShown(app, urgency) {
  const { session } = app;
  const result = session?.shown;
  if (!result) return;
  await measure(app.jobs, session, result, urgency);
  if (app.session !== session) return;
  showFigures(session);
  sayHeadline(session);
  showLevels(session, readOptions());
  await refreshShares(app.scene, result.pair);
  if (session.shown === result) showScaleOf(app, result);
  document.documentElement.dataset.measured = result.wish.title;
}

/** Says what became of the mesh; without a measurement, only its size. */
function sayHeadline({ file, mesh, shown }) {
  const { comparison } = shown;
  const original = { ...comparison?.original, bytes: sizeOf(file), faces: mesh.faces.length / 3 };
  const result = { bytes: sizeOf(shown.file), faces: shown.mesh.faces.length / 3, values: comparison?.results[0].values };
  fillHeadline(at('headline'), original, result);
}

function showScaleOf({ session, showScale }, { scale }) {
  showScale(scale, Math.hypot(...session.source.boxOf(0).sides));
}

async function download(app, ending) {
  const { session } = app;
  save(await convert(app.jobs, session, session.shown, ending));
}

/** Cancels all work; existing results stay. */
function stop(app) {
  app.idle = app.session ? 'Stopped. Finished results stay; choose a size to continue.' : 'Stopped.';
  cancel(app.jobs);
}

/** Returns whether a mesh is open. */
function setOpen(isOpen) {
  at('welcome').hidden = isOpen;
  document.documentElement.toggleAttribute('data-open', isOpen);
}

try {
  start();
} catch (error) {
  console.error(error);
  warn(`This page cannot start: ${oneLine(error)}. A browser of 2023 or newer with WebGL is needed.`);
}

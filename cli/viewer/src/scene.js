// What is in the panes: the original and the result that is chosen, unpacked when first shown, and how they are drawn.

import { Group } from 'three';
import { colourTexture } from './colours.js';
import { addCover, makeWardrobe, setCovers } from './cover.js';
import { farthestOf, makeRing } from './farthest.js';
import { addWire, makeMaterials, makeModel, makeRoomForWire, nPoints, paint, setShares, setTheme } from './model.js';
import { numbersOf } from './numbers.js';
import { refined } from './refine.js';
import { unpackShares, unpackSurface } from './surface.js';
import { askToDraw, lookAt, lookFromStart, setLight, setPlace } from './view.js';

/** Where the meshes of a comparison lie in the scene: the original's box around the origin, its diagonal 2 long. */
export function placeOf(surfaces, eye) {
  const { low, sides } = surfaces[0];
  const centre = low.map((x, axis) => x + sides[axis] / 2);
  const scale = 2 / (Math.hypot(...sides) || 1);
  const reach = (surface) => Math.hypot(...surface.low.map((x, axis) => (
    Math.max(Math.abs(x - centre[axis]), Math.abs(x + surface.sides[axis] - centre[axis])))));
  const half = sides.map((side) => 0.5 * side * scale);
  return { centre, scale, half, eye, radius: Math.max(...surfaces.map(reach)) * scale || 1 };
}

/**
 * Makes an empty scene in a view. Each of `pairs` names an original and a result, by their numbers among `surfaces`, and their
 * `distances`; `places` says of each original where it and its results lie.
 */
export function makeScene(view, { surfaces, covers, images, pairs }, places) {
  const roots = view.scenes.map(({ scene }) => {
    const root = new Group();
    scene.add(root);
    return root;
  });
  const materials = makeMaterials();
  const [models, results] = [new Map(), new Map()];
  const [texture, wardrobe] = [colourTexture(), makeWardrobe(images)];
  const place = places[pairs[0].original];
  return {
    view, surfaces, covers, pairs, places, place, roots, materials, wardrobe, loaded: { models, results }, texture, switches: {},
    models: [], shown: [], rings: roots.map(makeRing),
  };
}

/** What `make` gives for a key; the second time from memory, where the first one did not fail. */
function remembered(known, key, make) {
  if (!known.has(key)) {
    const loading = make();
    known.set(key, loading);
    loading.catch(() => known.delete(key));
  }
  return known.get(key);
}

async function loadModel({ surfaces, materials }, index, place) {
  const surface = await unpackSurface(surfaces[index], await numbersOf(`surface-${index}`), place);
  const { steps } = surfaces[index];
  return makeModel(surface, steps > 1 ? await refined(surface, steps) : surface, place.radius, materials);
}

/** Unpacks a result, and its original with the first one. */
async function loadPair(scene, { original: index, result, distances }) {
  const place = scene.places[index];
  const original = await remembered(scene.loaded.models, index, () => loadModel(scene, index, place));
  const model = await loadModel(scene, result, place);
  const numbers = await numbersOf(distances);
  setShares(model, await unpackShares(nPoints(model), numbers));
  return { original, model, sharesOfOriginal: await unpackShares(nPoints(original), numbers) };
}

/** Shows a pair, the result beside its original; of several calls the last one wins. Says whether this one did. */
export async function showPair(scene, at) {
  scene.wanted = at;
  const pair = scene.pairs[at];
  const { original, model, sharesOfOriginal } = await remembered(scene.loaded.results, at, () => loadPair(scene, pair));
  if (scene.wanted !== at) return false;
  setShares(original, sharesOfOriginal);
  scene.models = [original, model];
  scene.shown = [pair.original, pair.result];
  scene.roots.forEach((root, i) => root.clear().add(scene.models[i].group, scene.rings[i]));
  goTo(scene, scene.places[pair.original]);
  await applySwitches(scene);
  return scene.wanted === at;
}

/** Looks at another place, where the meshes are of another original. */
function goTo(scene, place) {
  if (scene.place === place) return;
  scene.place = place;
  setPlace(scene.view, place);
  turn(scene);
}

/** Draws as the switches say: {wire, flat, colours, texture, marks, zUp, farthest}. */
export async function setSwitches(scene, switches) {
  const isTurned = Boolean(switches.zUp) !== Boolean(scene.switches.zUp);
  const isAsked = switches.farthest && !scene.switches.farthest;
  scene.switches = switches;
  if (isTurned) turn(scene);
  await applySwitches(scene);
  if (isAsked) goToFarthest(scene);
}

/** Rings around the place where the meshes that are shown are farthest apart. */
function placeRings({ models, rings, switches }) {
  for (const ring of rings) ring.visible = Boolean(switches.farthest) && models.length > 0;
  if (!rings[0].visible) return;
  const { point } = farthestOf(models);
  for (const ring of rings) ring.position.copy(point);
}

/** Looks at that place from where its surface looks to. */
function goToFarthest({ view, models, roots }) {
  if (models.length === 0) return;
  const { point, normal } = farthestOf(models);
  roots[0].updateMatrixWorld();
  lookAt(view, roots[0].localToWorld(point), normal.transformDirection(roots[0].matrixWorld));
}

/** Turns the meshes so that the axis that is up in their files is up in the view. */
function turn({ view, roots, place, switches }) {
  const [x, y, z] = place.half;
  view.half = switches.zUp ? [x, z, y] : [x, y, z];
  roots.forEach((root) => { root.rotation.x = switches.zUp ? -Math.PI / 2 : 0; });
  lookFromStart(view);
}

async function applySwitches(scene) {
  const { view, materials, switches, models, shown } = scene;
  materials.solid.flatShading = switches.flat;
  paint(materials, switches.colours ? scene.texture : null);
  setLight(view, switches.colours || switches.texture);
  makeRoomForWire(materials, switches.wire);
  if (switches.wire) for (const model of models) await addWire(model, materials);
  if (switches.texture) await showCovers(scene, models, shown);
  // Where something else has been asked for meanwhile, that is what will be shown.
  if (scene.switches !== switches || scene.models !== models) return;
  placeRings(scene);
  for (const model of models) {
    if (model.wire) model.wire.visible = switches.wire;
    model.marks.visible = switches.marks;
    model.plain.visible = !(switches.texture && model.covered);
    if (model.covered) model.covered.visible = switches.texture;
  }
  askToDraw(view);
}

/** Makes the covers that models have, and draws them as the switches say. */
async function showCovers({ covers, wardrobe, switches }, models, shown) {
  for (const [pane, model] of models.entries()) {
    const cover = covers[shown[pane]];
    if (cover) await addCover(model, cover, shown[pane], wardrobe);
  }
  await setCovers(wardrobe, switches.flat, switches.wire);
}

/** Where the colours end, as a share of the largest distance. */
export function setColourEnd(scene, share) {
  scene.texture.repeat.x = 1 / Math.max(share, 1e-6);
  askToDraw(scene.view);
}

/** Takes the colours of the page. */
export function setSceneTheme(scene, colours) {
  setTheme(scene.materials, colours);
  scene.view.renderer.setClearColor(colours.stage);
  paint(scene.materials, scene.switches.colours ? scene.texture : null);
  askToDraw(scene.view);
}

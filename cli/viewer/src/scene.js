// What is in the panes: the original and the result that is chosen, unpacked when first shown, and how they are drawn.

import { Group } from 'three';
import { colourTexture } from './colours.js';
import { addCover, makeWardrobe, setCovers } from './cover.js';
import { addWire, makeMaterials, makeModel, makeRoomForWire, nPoints, paint, setShares, setTheme } from './model.js';
import { numbersOf } from './numbers.js';
import { refined } from './refine.js';
import { unpackShares, unpackSurface } from './surface.js';
import { askToDraw, lookFromStart, setLight } from './view.js';

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

/** Makes an empty scene in a view. */
export function makeScene(view, { surfaces, covers, images }, place) {
  const roots = view.scenes.map(({ scene }) => {
    const root = new Group();
    scene.add(root);
    return root;
  });
  const materials = makeMaterials();
  const loaded = new Map();
  const [texture, wardrobe] = [colourTexture(), makeWardrobe(images)];
  return { view, surfaces, covers, place, roots, materials, wardrobe, loaded, texture, switches: {}, models: [], shown: [] };
}

/** Unpacks a result, and the original with the first one; the second time from memory, where the first one did not fail. */
function load(scene, index) {
  const { loaded } = scene;
  if (!loaded.has(index)) {
    const loading = index === 0 ? loadModel(scene, 0) : loadResult(scene, index);
    loaded.set(index, loading);
    loading.catch(() => loaded.delete(index));
  }
  return loaded.get(index);
}

async function loadModel({ surfaces, place, materials }, index) {
  const surface = await unpackSurface(surfaces[index], await numbersOf(`surface-${index}`), place);
  const { steps } = surfaces[index];
  return makeModel(surface, steps > 1 ? await refined(surface, steps) : surface, place.radius, materials);
}

async function loadResult(scene, index) {
  const original = await load(scene, 0);
  const model = await loadModel(scene, index);
  const numbers = await numbersOf(`distances-${index}`);
  setShares(model, await unpackShares(nPoints(model), numbers));
  return { model, sharesOfOriginal: await unpackShares(nPoints(original), numbers) };
}

/** Shows a result, 1 to n, beside the original; of several calls the last one wins. Says whether this one did. */
export async function showResult(scene, index) {
  scene.wanted = index;
  const original = await load(scene, 0);
  const { model, sharesOfOriginal } = await load(scene, index);
  if (scene.wanted !== index) return false;
  setShares(original, sharesOfOriginal);
  scene.models = [original, model];
  scene.shown = [0, index];
  scene.roots.forEach((root, i) => root.clear().add(scene.models[i].group));
  await applySwitches(scene);
  return scene.wanted === index;
}

/** Draws as the switches say: {wire, flat, colours, texture, marks, zUp}. */
export async function setSwitches(scene, switches) {
  const isTurned = Boolean(switches.zUp) !== Boolean(scene.switches.zUp);
  scene.switches = switches;
  if (isTurned) turn(scene);
  await applySwitches(scene);
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

// The contents of the panes: the original and the chosen result, loaded when first shown, and how they are drawn.
//
// Meshes come from a source, an object of functions, most of which may return promises:
//   surface(index, place)   a mesh: positions, faces, normals; `fine`, the same as it is drawn; findEdges(), findMarked()
//   shares(pair, surfaces)  {ofResult, ofOriginal}: distances as shares of the largest, n_points x 2; null if unknown.
//                           `surfaces`, of original and result, if the points are not those of `fine`
//   hasCover(index)         whether a mesh has textures or colours; synchronous
//   cover(index, surface)   positions, normals, uvs, colours, faces by paint, runs, and the paints {image, wrap, color, coloured, finish}
//   image(index)            the file of an image as a blob

import { BufferAttribute, BufferGeometry, Group, Mesh } from 'three';
import { colourTexture } from './colours.js';
import { addCover, disposeWardrobe, makeWardrobe, setCovers } from './cover.js';
import { farthestOf, makeRing } from './farthest.js';
import {
  addMarks, addPainted, addWire, disposeModel, makeMaterials, makeModel, makeRoomForWire, paint, setShares, setTheme,
} from './model.js';
import { addGround, layGround } from './ground.js';
import { reflectedOf } from './reflected.js';
import { askForThumbnail, askToDraw, lookAt, lookFromStart, renewShadow, setFour, setLight, setPlace } from './view.js';

/** Returns the placement of a comparison in the scene: the original's box is centered and its diagonal 2. */
export function placeOf(surfaces, eye) {
  const { low, sides } = surfaces[0];
  const centre = low.map((x, axis) => x + sides[axis] / 2);
  const scale = 2 / (Math.hypot(...sides) || 1);
  const reach = (surface) => Math.hypot(...surface.low.map((x, axis) => (
    Math.max(Math.abs(x - centre[axis]), Math.abs(x + surface.sides[axis] - centre[axis])))));
  const half = sides.map((side) => 0.5 * side * scale);
  return { centre, scale, half, eye, radius: Math.max(...surfaces.map(reach)) * scale || 1 };
}

/** Creates a scene in a view, with a content for `setContent`. */
export function makeScene(view, content) {
  const roots = view.scenes.map(({ scene }) => {
    const root = new Group();
    scene.add(root);
    return root;
  });
  const scene = { view, roots, materials: makeMaterials(), texture: colourTexture(), switches: {}, rings: roots.map(makeRing) };
  addGround(view);
  fill(scene, content);
  layGround(view);
  return scene;
}

/** Draws a face without an area with the materials of meshes, so that their programs are compiled before the first mesh comes. */
export function warmUp({ view, roots, materials, models }) {
  if (models.length > 0) return;
  const geometry = new BufferGeometry();
  for (const name of ['position', 'normal']) geometry.setAttribute(name, new BufferAttribute(new Float32Array(9), 3));
  roots.forEach((root, i) => {
    const mesh = new Mesh(geometry, i === 0 ? materials.solid : materials.tinted);
    Object.assign(mesh, { castShadow: true, frustumCulled: false, onAfterRender: () => mesh.removeFromParent() });
    root.add(mesh);
  });
  askForThumbnail(view, new Mesh(geometry, materials.tinted), Object.assign(document.createElement('canvas'), { width: 1, height: 1 }));
  roots.forEach((_, pane) => renewShadow(view, pane));
}

/**
 * Empties a scene for other meshes. Each of `pairs` names an original and a result, by their numbers in the source; without a result
 * the original is shown alone. `places` says of each original where it and its results lie.
 */
export function setContent(scene, content) {
  const { loaded, wardrobe, roots, view } = scene;
  roots.forEach((root) => root.clear());
  for (const loading of [...loaded.models.values(), ...loaded.results.values()]) {
    loading.then(({ model }) => { if (model) disposeModel(model); }, () => {});
  }
  disposeWardrobe(wardrobe);
  fill(scene, content);
  setPlace(view, scene.place);
  turn(scene);
}

function fill(scene, { source, pairs, places }) {
  return Object.assign(scene, {
    source, pairs, places, place: places[pairs[0].original], wardrobe: makeWardrobe(source.image, () => reflectedOf(scene.view)),
    loaded: { models: new Map(), results: new Map() }, models: [], shown: [], shares: null, wanted: null, casters: [],
  });
}

/** Returns the result of `make` for a key, cached unless it failed. */
function remembered(known, key, make) {
  if (!known.has(key)) {
    const loading = make();
    known.set(key, loading);
    loading.catch(() => known.delete(key));
  }
  return known.get(key);
}

async function loadModel({ source }, index, place, material) {
  return { model: makeModel(await source.surface(index, place), place.radius, material) };
}

/** Loads a result, and its original with the first one. */
async function loadPair(scene, pair) {
  const { source, loaded, places, materials } = scene;
  const place = places[pair.original];
  const { model: original } = await remembered(loaded.models, pair.original, () => (
    loadModel(scene, pair.original, place, materials.solid)));
  if (pair.result === undefined) return { original, model: null, shares: null };
  const { model } = await loadModel(scene, pair.result, place, materials.tinted);
  const shares = await source.shares(pair, [original.surface, model.surface]);
  return { original, model, shares };
}

/** Shows an original and its result; returns false if a later call replaced this one. */
export async function showPair(scene, at) {
  scene.wanted = at;
  const { loaded } = scene;
  const pair = scene.pairs[at];
  const { original, model, shares } = await remembered(loaded.results, at, () => loadPair(scene, pair));
  if (scene.wanted !== at || scene.loaded !== loaded) return false;
  scene.models = model ? [original, model] : [original];
  scene.shown = [pair.original, pair.result];
  wearShares(scene, shares);
  scene.roots.forEach((root) => root.clear());
  scene.models.forEach(({ group }, i) => scene.roots[i].add(group, scene.rings[i]));
  goTo(scene, scene.places[pair.original]);
  await applySwitches(scene);
  return scene.wanted === at && scene.loaded === loaded;
}

/** Draws the result of a pair as it is first seen, with its materials if it has any, into a 2-D canvas. */
export async function drawThumbnail(scene, at, canvas) {
  const { loaded, source, wardrobe, pairs, view, switches } = scene;
  const { model } = await remembered(loaded.results, at, () => loadPair(scene, pairs[at]));
  const index = pairs[at].result;
  if (source.hasCover(index)) await addCover(model, () => source.cover(index, model.surface), wardrobe);
  if (scene.loaded !== loaded) return;
  const { geometry, material } = model.covered ?? model.plain;
  const object = new Mesh(geometry, material);
  object.rotation.x = switches.zUp ? -Math.PI / 2 : 0;
  askForThumbnail(view, object, canvas);
}

/** Forgets a pair that will not be shown again. */
export function dropPair({ loaded }, at) {
  loaded.results.get(at)?.then(({ model }) => { if (model) disposeModel(model); }, () => {});
  loaded.results.delete(at);
}

function wearShares(scene, shares) {
  scene.shares = shares;
  if (!shares) return;
  const { models } = scene;
  shares.surfaces?.forEach((measured, i) => { if (measured) addPainted(models[i], measured); });
  setShares(models[0], shares.ofOriginal);
  setShares(models[1], shares.ofResult);
}

/** Reloads the distances of a pair, which its source may know by now. */
export async function refreshShares(scene, at) {
  const { loaded } = scene;
  const pair = await loaded.results.get(at);
  if (!pair) return;
  pair.shares = await scene.source.shares(scene.pairs[at], [pair.original.surface, pair.model.surface]);
  if (scene.wanted !== at || scene.loaded !== loaded || scene.models[1] !== pair.model) return;
  wearShares(scene, pair.shares);
  await applySwitches(scene);
}

/** Resets the camera if the meshes belong to another original. */
function goTo(scene, place) {
  if (scene.place === place) return;
  scene.place = place;
  setPlace(scene.view, place);
  turn(scene);
}

/** Draws as the switches say: {wire, flat, colours, texture, marks, zUp, farthest, four}. */
export async function setSwitches(scene, switches) {
  const isTurned = Boolean(switches.zUp) !== Boolean(scene.switches.zUp);
  const isAsked = switches.farthest && !scene.switches.farthest;
  scene.switches = switches;
  setFour(scene.view, Boolean(switches.four));
  if (isTurned) turn(scene);
  await applySwitches(scene);
  if (isAsked) goToFarthest(scene);
}

/** Puts rings around the point where the shown meshes are farthest apart. */
function placeRings({ models, rings, shares, switches }) {
  for (const ring of rings) ring.visible = Boolean(switches.farthest && shares);
  if (!rings[0].visible) return;
  const { point } = farthestOf(models);
  for (const ring of rings) ring.position.copy(point);
}

/** Looks at the farthest point along its normal. */
function goToFarthest({ view, models, roots, shares }) {
  if (!shares) return;
  const { point, normal } = farthestOf(models);
  roots[0].updateMatrixWorld();
  lookAt(view, roots[0].localToWorld(point), normal.transformDirection(roots[0].matrixWorld));
}

/** Turns the meshes so that the axis that is up in their files is up in the view. */
function turn({ view, roots, place, switches }) {
  const [x, y, z] = place.half;
  view.half = switches.zUp ? [x, z, y] : [x, y, z];
  roots.forEach((root) => { root.rotation.x = switches.zUp ? -Math.PI / 2 : 0; });
  layGround(view);
  lookFromStart(view);
}

async function applySwitches(scene) {
  const { view, materials, switches, models, shown } = scene;
  for (const material of [materials.solid, materials.tinted]) material.flatShading = switches.flat;
  paintSolid(scene);
  setLight(view, hasColours(scene) || switches.texture);
  makeRoomForWire(materials, switches.wire);
  if (switches.wire) for (const model of models) await addWire(model, materials);
  if (switches.marks) for (const model of models) await addMarks(model, materials);
  if (switches.texture) await showCovers(scene, models, shown);
  // A newer choice replaces this one.
  if (scene.switches !== switches || scene.models !== models) return;
  placeRings(scene);
  for (const model of models) {
    if (model.wire) model.wire.visible = switches.wire;
    if (model.marks) model.marks.visible = switches.marks;
    const isPainted = Boolean(model.painted) && hasColours(scene);
    model.plain.visible = !(switches.texture && model.covered) && !isPainted;
    if (model.painted) model.painted.visible = isPainted;
    if (model.covered) model.covered.visible = switches.texture;
  }
  renewShadows(scene);
  askToDraw(view);
}

/** Makes the shadows of panes again that show another surface or the surface turned. */
function renewShadows({ view, roots, models, switches, casters }) {
  roots.forEach((_, pane) => {
    const { plain, painted, covered } = models[pane] ?? {};
    const caster = [plain, painted, covered].find((object) => object?.visible);
    const before = casters[pane];
    if (before && before.caster === caster && before.zUp === switches.zUp) return;
    casters[pane] = { caster, zUp: switches.zUp };
    renewShadow(view, pane);
  });
}

/** Returns whether distances are shown as colours: switched on and known. */
function hasColours({ switches, shares }) {
  return Boolean(switches.colours && shares);
}

function paintSolid(scene) {
  paint(scene.materials, hasColours(scene) ? scene.texture : null);
}

/** Loads the covers of the models, and draws them as the switches say. */
async function showCovers({ source, wardrobe, switches }, models, shown) {
  for (const [pane, model] of models.entries()) {
    const index = shown[pane];
    if (source.hasCover(index)) await addCover(model, () => source.cover(index, model.surface), wardrobe);
  }
  await setCovers(wardrobe, switches.flat, switches.wire);
}

/** Sets the end of the colour scale, as a share of the largest distance. */
export function setColourEnd(scene, share) {
  scene.texture.repeat.x = 1 / Math.max(share, 1e-6);
  askToDraw(scene.view);
}

/** Applies the colours of the page's theme. */
export function setSceneTheme(scene, colours) {
  setTheme(scene.materials, colours);
  scene.view.renderer.setClearColor(colours.stage, 0);
  paintSolid(scene);
  askToDraw(scene.view);
}

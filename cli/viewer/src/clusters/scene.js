// A hierarchy in a view: before each frame, decides the cut, asks for its pages, and draws it.

import { Frustum, Matrix4 } from 'three';
import { addGroups, placeBox } from '../single.js';
import { askToDraw, setLight } from '../view.js';
import { coarseGroups, isDrawn, isInView, replacedGroups } from './cut.js';
import { COLOURINGS, makeClusterMaterial } from './material.js';
import { drawnTriangles, makePageMesh, setDrawn } from './meshes.js';
import { decodePage } from './page.js';
import { closeStore, hasRoots, isComplete, isWaiting, makeStore, want } from './store.js';

/** Most bytes of pages that stay loaded. */
const BUDGET = 256 * 2 ** 20;

/**
 * Shows a hierarchy in a view in place of an earlier scene. `settings` {pixels, colouring, isFrozen, zUp} may change between frames.
 * `failed(error)` is called for pages that cannot be shown.
 */
export function makeClusterScene(view, hierarchy, settings, { before, failed, budget = BUDGET }) {
  if (before) removeScene(view, before);
  const isFlat = !hierarchy.header.channels.some(({ role, width }) => role === 'normal' && width === 3);
  const scene = {
    view, hierarchy, settings, ...addGroups(view), material: makeClusterMaterial({ isFlat }), pages: new Map(),
    eyeOfCut: null, isPlaced: false, cut: { nClusters: 0, nTriangles: 0, ofLevels: [] },
  };
  const arrived = (page, bytes) => {
    const made = makePageMesh(decodePage(hierarchy, page, bytes), scene.material);
    scene.pages.set(page, made);
    scene.body.add(made.mesh);
    askToDraw(view);
  };
  const dropped = (page) => removePage(scene, page);
  scene.store = makeStore(hierarchy, Math.max(Math.floor(budget / hierarchy.header.page_size), 1), { arrived, dropped, failed });
  view.beforePane = ({ height }) => {
    view.renderer.info.reset();
    update(scene, height);
  };
  want(scene.store, []);
  return scene;
}

function removeScene(view, { root, store, pages, material }) {
  closeStore(store);
  view.scenes[0].scene.remove(root);
  for (const { mesh } of pages.values()) mesh.geometry.dispose();
  material.dispose();
}

function removePage({ pages, body }, page) {
  const { mesh } = pages.get(page);
  body.remove(mesh);
  mesh.geometry.dispose();
  pages.delete(page);
}

/** Sets the colours of a theme. */
export function setClusterTheme({ material, view }, { surface, stage }) {
  material.color.set(surface);
  view.renderer.setClearColor(stage);
  askToDraw(view);
}

/** Returns whether something of the hierarchy is drawn, and nothing that it needs is on its way. */
export function isSettled({ store, isPlaced }) {
  return isPlaced && !isWaiting(store);
}

/** Returns the corners' positions of all drawn triangles, 9 numbers each. */
export function trianglesOf({ pages }) {
  return [...pages.values()].flatMap(({ mesh }) => drawnTriangles(mesh));
}

/** Decides the cut for the camera and draws it. */
function update(scene, height) {
  const { hierarchy, store, settings, view, material } = scene;
  if (!hasRoots(store)) return;
  if (!scene.isPlaced) place(scene);
  const eye = eyeOf(scene, height);
  material.uniforms.pixels.value = eye.pixels * scene.root.scale.x;
  // Even light keeps colours that mean something alike on all sides.
  setLight(view, settings.colouring !== 'surface');
  material.uniforms.colouring.value = COLOURINGS.indexOf(settings.colouring);
  // A frozen cut stays that of the camera when it was frozen.
  if (!settings.isFrozen || !scene.eyeOfCut) scene.eyeOfCut = eye;
  const coarse = coarseGroups(hierarchy, scene.eyeOfCut, settings.pixels);
  want(store, coarse.filter((group) => isInView(hierarchy.groups, group, scene.eyeOfCut.planes)));
  const replaced = replacedGroups(hierarchy, coarse, (group) => isComplete(store, group));
  let nChanged = 0;
  for (const page of scene.pages.values()) nChanged += setDrawn(page, (cluster) => isDrawn(hierarchy, replaced, cluster));
  if (nChanged > 0) scene.cut = countCut(scene);
}

/** Returns the camera in the mesh's coordinates, as the cut sees it. */
function eyeOf({ root, body, view: { camera, renderer } }, height) {
  root.updateMatrixWorld();
  camera.updateMatrixWorld();
  const { x, y, z } = body.worldToLocal(camera.position.clone());
  const toImage = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(body.matrixWorld);
  const planes = new Frustum().setFromProjectionMatrix(toImage).planes;
  const tangent = Math.tan((camera.fov / 2) * (Math.PI / 180));
  return {
    eye: [x, y, z],
    pixels: (height * renderer.getPixelRatio()) / (2 * tangent),
    near: camera.near / root.scale.x,
    planes: planes.map(({ normal, constant }) => [normal.x, normal.y, normal.z, constant]),
  };
}

/** Centers the box of the coarsest level, and looks at all of it. */
function place(scene) {
  const { store, hierarchy: { clusters }, pages } = scene;
  const level = clusters.levels.reduce((a, b) => Math.max(a, b));
  placeBox(scene, (visit) => {
    for (const page of store.rootPages) {
      const { position, facts } = pages.get(page).mesh.geometry.attributes;
      for (let v = 0; v < position.count; v++) {
        if (facts.getY(v) === level) visit(position.getX(v), position.getY(v), position.getZ(v));
      }
    }
  });
  scene.isPlaced = true;
}

/** Counts clusters and triangles of the cut, in all and of each level. */
function countCut({ pages, hierarchy: { clusters } }) {
  const cut = { nClusters: 0, nTriangles: 0, ofLevels: [] };
  for (const { contents, drawn } of pages.values()) {
    contents.forEach((cluster, i) => {
      if (!drawn[i]) return;
      const [level, nFaces] = [clusters.levels[cluster], clusters.nFaces[cluster]];
      const ofLevel = (cut.ofLevels[level] ??= { nClusters: 0, nTriangles: 0 });
      for (const sum of [cut, ofLevel]) {
        sum.nClusters++;
        sum.nTriangles += nFaces;
      }
    });
  }
  return cut;
}

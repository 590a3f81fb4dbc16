// A hierarchy in a view: before each frame, decides the cut, asks for its pages, and draws it.

import { Frustum, Matrix4 } from 'three';
import { addGroups, placeBox } from '../single.js';
import { askToDraw, setLight } from '../view.js';
import { coarseGroups, isDrawn, isInView, replacedGroups } from './cut.js';
import { COLOURINGS, makeClusterMaterial, makeUniforms } from './material.js';
import { drawnTriangles, makePageMesh, setDrawn } from './meshes.js';
import { decodePage } from './page.js';
import { closeStore, hasRoots, isComplete, isWaiting, makeStore, want } from './store.js';

/** Most bytes of pages that stay loaded. */
const BUDGET = 256 * 2 ** 20;

/**
 * Shows a hierarchy in a view in place of an earlier scene. `settings` {pixels, colouring, isFrozen, zUp} may change between frames.
 * `failed(error)` is called for pages that cannot be shown.
 */
export function makeClusterScene(view, hierarchy, settings, { before, failed, paints, budget = BUDGET }) {
  if (before) removeScene(view, before);
  const isFlat = !hierarchy.header.channels.some(({ role, width }) => role === 'normal' && width === 3);
  const uniforms = makeUniforms();
  const materials = paints.all.map((paint) => makeClusterMaterial(uniforms, { isFlat, ...paint }));
  const order = { nPaints: materials.length, paintOf: paints.paintOf, isVUp: paints.isVUp };
  const scene = {
    view, hierarchy, settings, ...addGroups(view), uniforms, materials, pages: new Map(),
    eyeOfCut: null, isPlaced: false, cut: { nClusters: 0, nTriangles: 0, ofLevels: [] },
  };
  const arrived = (page, bytes) => {
    const made = makePageMesh(decodePage(hierarchy, page, bytes, order), materials);
    scene.pages.set(page, made);
    scene.body.add(made.mesh);
    askToDraw(view);
  };
  const dropped = (page) => removePage(scene, page);
  scene.store = makeStore(hierarchy, Math.max(Math.floor(budget / hierarchy.header.page_size), 1), { arrived, dropped, failed });
  view.beforePane = (pane) => {
    view.renderer.info.reset();
    update(scene, pane);
  };
  want(scene.store, []);
  return scene;
}

function removeScene(view, { root, store, pages, materials }) {
  closeStore(store);
  view.scenes[0].scene.remove(root);
  for (const { mesh } of pages.values()) mesh.geometry.dispose();
  for (const material of materials) {
    material.map?.dispose();
    material.dispose();
  }
}

function removePage({ pages, body }, page) {
  const { mesh } = pages.get(page);
  body.remove(mesh);
  mesh.geometry.dispose();
  pages.delete(page);
}

/** Sets the colours of a theme. */
export function setClusterTheme({ materials, view }, { surface, stage }) {
  for (const material of materials) material.color.set(surface);
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
function update(scene, pane) {
  const { hierarchy, store, settings, view, uniforms } = scene;
  if (!hasRoots(store)) return;
  if (!scene.isPlaced) place(scene);
  const eye = eyeOf(scene, pane);
  uniforms.pixels.value = eye.pixels * scene.root.scale.x;
  // Even light keeps colours that mean something alike on all sides.
  setLight(view, !['surface', 'texture'].includes(settings.colouring));
  uniforms.colouring.value = COLOURINGS.indexOf(settings.colouring);
  // A frozen cut stays that of the camera when it was frozen.
  if (!settings.isFrozen || !scene.eyeOfCut) scene.eyeOfCut = eye;
  const coarse = coarseGroups(hierarchy, scene.eyeOfCut, settings.pixels);
  want(store, coarse.filter((group) => isInView(hierarchy.groups, group, scene.eyeOfCut.planes)));
  const replaced = replacedGroups(hierarchy, coarse, (group) => isComplete(store, group));
  // What is outside of the view is part of the cut, and not drawn; a frozen cut is seen by the camera as it is now.
  const isVisible = (cluster) => isInView(hierarchy.clusters, cluster, eye.planes);
  let nChanged = 0;
  for (const page of scene.pages.values()) nChanged += setDrawn(page, (cluster) => isDrawn(hierarchy, replaced, cluster), isVisible);
  if (nChanged > 0) scene.cut = countCut(scene);
}

/** Returns the camera in the mesh's coordinates, as the cut sees it. */
function eyeOf({ root, body, view: { camera, renderer } }, { width, height }) {
  root.updateMatrixWorld();
  camera.aspect = width / Math.max(height, 1);
  camera.updateProjectionMatrix();
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

/** Centers the box of the finest level, and looks at all of it. */
function place(scene) {
  const { header: { bounds }, clusters } = scene.hierarchy;
  placeBox(scene, (visit) => {
    if (bounds) return bounds.forEach((corner) => visit(...corner));
    // The spheres of the finest clusters contain the mesh.
    return clusters.levels.forEach((level, cluster) => {
      const [x, y, z, radius] = clusters.spheres.subarray(4 * cluster, 4 * cluster + 4);
      if (level > 0) return;
      for (const side of [-radius, radius]) visit(x + side, y + side, z + side);
    });
  });
  scene.isPlaced = true;
}

/** Counts clusters and triangles of the cut, in all and of each level. */
function countCut({ pages, hierarchy: { clusters } }) {
  const cut = { nClusters: 0, nTriangles: 0, ofLevels: [] };
  for (const { contents, chosen } of pages.values()) {
    contents.forEach((cluster, i) => {
      if (!chosen[i]) return;
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

// Two panes under one camera, drawn when something has changed. Independent of meshes and figures.

import {
  DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Spherical, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

/** Creates the view of a canvas with panes as elements over it, of a box around the origin, first seen from `eye`. */
export function makeView(canvas, panes, { half, radius, eye }) {
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  renderer.setScissorTest(true);
  renderer.info.autoReset = false;
  const camera = new PerspectiveCamera(30, 1, 0.01, 100);
  const view = { renderer, camera, panes, half, radius, eye: new Vector3(...eye), wipe: null, asked: false, isMoved: false };
  view.scenes = panes.map(makeScene);
  view.controls = new OrbitControls(camera, canvas);
  view.controls.addEventListener('change', () => askToDraw(view));
  view.controls.addEventListener('start', () => { view.isMoved = true; });
  new ResizeObserver(() => resize(view)).observe(canvas);
  resize(view);
  return view;
}

function makeScene() {
  const scene = new Scene();
  const sky = new HemisphereLight(0xffffff, 0xa6a6ac, 1);
  const lamp = new DirectionalLight(0xffffff, 1);
  scene.add(sky, lamp, lamp.target);
  return { scene, sky, lamp };
}

/** Returns the corners of a box. */
const SIGNS = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => new Vector3(x, y, z))));

/** Sets even light for meaningful colours, and more shading on a plain surface. */
export function setLight(view, isEven) {
  for (const { sky, lamp } of view.scenes) {
    sky.intensity = isEven ? 2.3 : 1.3;
    lamp.intensity = isEven ? 1.1 : 2.1;
  }
}

function resize(view) {
  const { clientWidth, clientHeight } = view.renderer.domElement;
  view.renderer.setPixelRatio(Math.min(globalThis.devicePixelRatio, 2));
  view.renderer.setSize(Math.max(clientWidth, 1), Math.max(clientHeight, 1), false);
  // Until the reader moves the camera, the whole box stays visible at any size.
  if (!view.isMoved) lookFromStart(view);
  askToDraw(view);
}

/** Schedules one drawing before the next frame. */
export function askToDraw(view) {
  if (view.asked) return;
  view.asked = true;
  requestAnimationFrame(() => draw(view));
}

function draw(view) {
  view.asked = false;
  const stage = view.renderer.domElement.getBoundingClientRect();
  fitDepth(view);
  view.panes.forEach((pane, i) => {
    const box = pane.getBoundingClientRect();
    const frame = [box.left - stage.left, stage.bottom - box.bottom, box.width, box.height];
    view.renderer.setViewport(...frame);
    view.renderer.setScissor(...shownPart(frame, i, view.wipe));
    view.camera.aspect = box.width / Math.max(box.height, 1);
    view.camera.updateProjectionMatrix();
    view.beforePane?.(box);
    view.scenes[i].lamp.position.copy(lampPosition(view));
    view.scenes[i].lamp.target.position.copy(view.controls.target);
    view.renderer.render(view.scenes[i].scene, view.camera);
  });
  view.drawn?.();
}

/** Returns the drawn rectangle of a pane: all of it, or its side of the divider under a wipe. */
function shownPart([left, bottom, width, height], pane, wipe) {
  if (wipe === null) return [left, bottom, width, height];
  return pane === 0 ? [left, bottom, wipe * width, height] : [left + wipe * width, bottom, (1 - wipe) * width, height];
}

/** Draws the panes over each other, split by a divider at a share of the width; null draws them side by side. */
export function setWipe(view, wipe) {
  const isOther = (view.wipe === null) !== (wipe === null);
  view.wipe = wipe;
  // The panes have changed their shape.
  if (isOther && !view.isMoved) lookFromStart(view);
  askToDraw(view);
}

/** Moves the light a little above and to the left of the eye. */
function lampPosition({ camera, controls }) {
  const side = new Vector3(-0.35, 0.45, 0).applyQuaternion(camera.quaternion);
  return camera.position.clone().addScaledVector(side, camera.position.distanceTo(controls.target));
}

/** Fits the depth range to the scene, so that close surfaces are resolved. */
function fitDepth({ camera, controls, radius }) {
  const distance = camera.position.length();
  camera.near = Math.max(distance - 1.1 * radius, 0.02 * camera.position.distanceTo(controls.target));
  camera.far = distance + 1.1 * radius;
}

/** Changes the box and the direction from which it is first seen. */
export function setPlace(view, { half, radius, eye }) {
  Object.assign(view, { half, radius, eye: new Vector3(...eye) });
}

/** Moves the camera so that the whole box is visible. */
export function lookFromStart(view) {
  const { camera, controls, radius } = view;
  view.isMoved = false;
  controls.target.set(0, 0, 0);
  camera.position.copy(view.eye);
  camera.lookAt(controls.target);
  camera.position.setLength(1.06 * distanceToFit(view));
  controls.minDistance = 0.01 * radius;
  controls.maxDistance = 40 * radius;
  controls.update();
  askToDraw(view);
}

/** Looks at a point from nearby, from a given direction. */
export function lookAt(view, point, direction) {
  const { camera, controls, radius } = view;
  view.isMoved = true;
  controls.target.copy(point);
  camera.position.copy(point).addScaledVector(direction, 1.2 * radius);
  controls.update();
  askToDraw(view);
}

/** Returns the distance of the camera from the center at which every corner of the box is inside the pane. */
function distanceToFit({ camera, panes, half }) {
  const { width, height } = panes[0].getBoundingClientRect();
  const up = Math.tan((camera.fov / 2) * (Math.PI / 180));
  const right = up * (width / Math.max(height, 1));
  const toCamera = camera.quaternion.clone().invert();
  const needed = (sign) => {
    const corner = new Vector3(...half).multiply(sign).applyQuaternion(toCamera);
    return corner.z + Math.max(Math.abs(corner.x) / right, Math.abs(corner.y) / up);
  };
  return Math.max(...SIGNS.map(needed));
}

/** Turns the camera around its target, by radians to the right and up. */
export function orbit(view, right, up) {
  const { camera, controls } = view;
  const place = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
  place.theta += right;
  place.phi -= up;
  camera.position.setFromSpherical(place.makeSafe()).add(controls.target);
  moved(view);
}

/** Scales the distance of the camera: below 1 closer, above 1 farther. */
export function zoom(view, factor) {
  const { camera, controls } = view;
  camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
  moved(view);
}

/** Moves camera and target sideways, in shares of their distance. */
export function pan(view, right, up) {
  const { camera, controls } = view;
  const step = new Vector3(right, up, 0).applyQuaternion(camera.quaternion);
  step.multiplyScalar(camera.position.distanceTo(controls.target));
  camera.position.add(step);
  controls.target.add(step);
  moved(view);
}

function moved(view) {
  view.isMoved = true;
  view.controls.update();
}

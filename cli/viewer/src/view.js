// Two panes under one camera, drawn when something has changed. Independent of meshes and figures.

import {
  DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Spherical, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

/** Creates the view of a canvas with panes as elements over it, of a box around the origin, first seen from `eye`. */
export function makeView(canvas, panes, { half, radius, eye }) {
  // The page shows through where nothing is drawn.
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.setScissorTest(true);
  renderer.info.autoReset = false;
  const camera = new PerspectiveCamera(30, 1, 0.01, 100);
  const view = { renderer, camera, panes, half, radius, eye: new Vector3(...eye), wipe: null, isFour: false, asked: false, isMoved: false, oldShadows: new Set([0, 1]), grounds: [], thumbnails: [] };
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
  const sky = new HemisphereLight(0xffffff, 0x8d8a86, 1);
  const lamp = new DirectionalLight(0xffffff, 1);
  // Sets outlines off from the background.
  const rim = new DirectionalLight(0xffffff, 0.5);
  rim.position.set(0.4, 0.7, -1);
  scene.add(sky, lamp, lamp.target, rim);
  return { scene, sky, lamp, rim };
}

/** Returns the corners of a box. */
const SIGNS = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => new Vector3(x, y, z))));

/** Sets even light for meaningful colours, and more shading on a plain surface. */
export function setLight(view, isEven) {
  for (const { sky, lamp, rim } of view.scenes) {
    sky.intensity = isEven ? 2.3 : 1.25;
    lamp.intensity = isEven ? 1.1 : 2;
    rim.intensity = isEven ? 0.2 : 0.7;
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
  // A frame after the copying of another has rough outlines.
  if (view.thumbnails.length > 0) askToDraw(view);
  drawThumbnails(view);
  const stage = view.renderer.domElement.getBoundingClientRect();
  fitDepth(view);
  view.panes.forEach((pane, i) => {
    const box = pane.getBoundingClientRect();
    const frame = [box.left - stage.left, stage.bottom - box.bottom, box.width, box.height];
    const shown = shownPart(frame, i, view.wipe);
    view.beforePane?.(box);
    // The first drawing of a pane makes its shadow.
    view.renderer.shadowMap.needsUpdate = view.oldShadows.has(i);
    if (view.isFour) drawFour(view, view.scenes[i], frame, shown);
    else drawScene(view, view.scenes[i], view.camera, frame, shown);
  });
  view.oldShadows.clear();
  view.drawn?.();
}

function drawScene({ renderer, controls }, { scene, lamp }, camera, frame, shown) {
  // Three.js rounds a frame, and rounds it down after it has made a shadow.
  renderer.setViewport(...frame.map(Math.round));
  renderer.setScissor(...shown);
  camera.aspect = frame[2] / Math.max(frame[3], 1);
  camera.updateProjectionMatrix();
  lamp.position.copy(lampPosition({ camera, controls }));
  lamp.target.position.copy(controls.target);
  renderer.render(scene, camera);
}

/** Draws a pane from four sides: as the reader looks, a quarter turn to the right, from behind, and from above. */
function drawFour(view, scene, [left, bottom, width, height], [shownLeft, shownBottom, shownWidth, shownHeight]) {
  const { camera, controls } = view;
  const place = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
  const sides = [[0, place.phi], [Math.PI / 2, place.phi], [Math.PI, place.phi], [0, 0.02]];
  sides.forEach(([turn, phi], at) => {
    const [x, y] = [left + (at % 2) * 0.5 * width, bottom + (at < 2 ? 0.5 : 0) * height];
    const other = camera.clone();
    other.position.setFromSpherical(new Spherical(place.radius, phi, place.theta + turn)).add(controls.target);
    other.lookAt(controls.target);
    const [from, to] = [Math.max(x, shownLeft), Math.min(x + 0.5 * width, shownLeft + shownWidth)];
    const [low, high] = [Math.max(y, shownBottom), Math.min(y + 0.5 * height, shownBottom + shownHeight)];
    if (to <= from || high <= low) return;
    drawScene(view, scene, other, [x, y, 0.5 * width, 0.5 * height], [from, low, to - from, high - low]);
  });
}

/** Draws each pane from one side, or from four at once. */
export function setFour(view, isFour) {
  view.isFour = isFour;
  askToDraw(view);
}

/** Makes the shadow of a pane again with the next drawing, as its mesh has changed. */
export function renewShadow(view, pane) {
  view.oldShadows.add(pane);
  askToDraw(view);
}

/** Draws an object from the first side into a 2-D canvas with the next frame. */
export function askForThumbnail(view, object, canvas) {
  view.thumbnails.push({ object, canvas });
  askToDraw(view);
}

/** Draws the waiting thumbnails in a corner of the canvas, from which they are copied; the frame is drawn over it. */
function drawThumbnails(view) {
  const { renderer, controls } = view;
  const ratio = renderer.getPixelRatio();
  for (const { object, canvas } of view.thumbnails.splice(0)) {
    const frame = [0, 0, canvas.width / ratio, canvas.height / ratio];
    const scene = makeScene();
    setLight({ scenes: [scene] }, true);
    scene.scene.add(object);
    const camera = view.camera.clone();
    camera.position.copy(view.eye);
    camera.lookAt(0, 0, 0);
    camera.position.setLength(0.92 * distanceToFit({ camera, half: view.half }, canvas.width / canvas.height));
    Object.assign(camera, { near: 0.01, far: 100 });
    drawScene({ renderer, controls: { target: controls.target.clone().set(0, 0, 0) } }, scene, camera, frame, frame);
    const context = canvas.getContext('2d');
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.drawImage(renderer.domElement, 0, renderer.domElement.height - canvas.height, canvas.width, canvas.height, 0, 0, canvas.width, canvas.height);
  }
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
  // Behind the meshes there may be a ground.
  camera.far = distance + 4.5 * radius;
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
  const { width, height } = view.panes[0].getBoundingClientRect();
  camera.position.setLength(1.06 * distanceToFit(view, Math.max(width, 1) / Math.max(height, 1)));
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

/** Returns the distance of the camera from the center at which every corner of the box is inside a pane of this aspect. */
function distanceToFit({ camera, half }, aspect) {
  const up = Math.tan((camera.fov / 2) * (Math.PI / 180));
  const right = up * aspect;
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

// A progression in a view: before each frame, makes the level of the chosen size, if it is another one.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, LineSegments, Mesh } from 'three';
import { sendFirst } from '../buffers.js';
import { makeMaterials, makeRoomForWire, paint, setTheme, wireOpacity } from '../model.js';
import { addGroups, placeBox } from '../single.js';
import { fillNormals } from '../surface.js';
import { askToDraw, setLight } from '../view.js';
import { fillLevel, findLevel, makeRoom, ranksOf } from './level.js';
import { placeLevel } from './placement.js';
import { restore } from './scale.js';

/** Shows a progression in a view in place of an earlier scene. `settings` {size, wire, flat} may change between frames. */
export function makeProgressionScene(view, progression, settings, before) {
  if (before) removeScene(before);
  const { placement } = progression;
  const own = makeRoom(progression);
  const room = placement ? { positions: new Float32Array(3 * placement.most.nVertices), faces: new Uint32Array(3 * placement.most.nFaces) } : own;
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', dynamic(room.positions, 3));
  geometry.setAttribute('normal', dynamic(new Float32Array(room.positions.length), 3));
  geometry.setIndex(dynamic(room.faces, 1));
  const materials = makeMaterials();
  const solid = new Mesh(geometry, materials.solid);
  solid.frustumCulled = false;
  const scene = { view, progression, settings, own, room, materials, solid, wire: null, level: null, drawn: {}, ...addGroups(view) };
  scene.body.add(solid);
  setLight(view, false);
  const { nVertices } = fillRoom(scene, findLevel(progression, { vertices: Infinity, faces: Infinity }));
  placeBox(scene, (visit) => {
    for (let i = 0; i < 3 * nVertices; i += 3) visit(room.positions[i], room.positions[i + 1], room.positions[i + 2]);
  });
  view.beforePane = () => {
    view.renderer.info.reset();
    update(scene);
  };
  return scene;
}

/** Writes a level, with all instances in a scene; returns the numbers of drawn vertices and faces. */
function fillRoom({ progression, own, room }, level) {
  fillLevel(progression, level, own);
  if (own === room) return level;
  const { nVertices, nFaces } = level;
  const mesh = { positions: restore(own.positions.subarray(0, 3 * nVertices), progression.scale), faces: own.faces.subarray(0, 3 * nFaces) };
  return placeLevel(progression.placement, ranksOf(progression, level), mesh, room);
}

function dynamic(array, width) {
  return new BufferAttribute(array, width).setUsage(DynamicDrawUsage);
}

function removeScene({ view, root, solid, wire, materials }) {
  view.scenes[0].scene.remove(root);
  for (const object of [solid, wire]) object?.geometry.dispose();
  for (const material of [materials.solid, materials.tinted, materials.wire, ...materials.marks]) material.dispose();
}

/** Sets the colours of a theme. */
export function setProgressionTheme({ materials, view }, colours) {
  setTheme(materials, colours);
  paint(materials, null);
  view.renderer.setClearColor(colours.stage);
  askToDraw(view);
}

/** Returns the corners' positions of all drawn triangles, 9 numbers each, at unit size. */
export function trianglesOf({ room: { positions, faces }, shown }) {
  return Array.from(faces.subarray(0, 3 * shown.nFaces)).flatMap((v) => [...positions.subarray(3 * v, 3 * v + 3)]);
}

/** Makes what the settings ask for and was not drawn last. */
function update(scene) {
  const { progression, settings: { size, wire, flat }, room, solid, materials, drawn } = scene;
  const { position, normal } = solid.geometry.attributes;
  if (drawn.size !== size) {
    scene.level = findLevel(progression, { vertices: size, faces: Infinity });
    scene.shown = fillRoom(scene, scene.level);
    sendFirst(position, 3 * scene.shown.nVertices);
    sendFirst(solid.geometry.index, 3 * scene.shown.nFaces);
    solid.geometry.setDrawRange(0, 3 * scene.shown.nFaces);
    Object.assign(drawn, { size, hasNormals: false, hasEdges: false });
  }
  const { nVertices, nFaces } = scene.shown;
  // Flat faces take no normals from the vertices.
  if (!flat && !drawn.hasNormals) {
    fillNormals(room.positions.subarray(0, 3 * nVertices), room.faces.subarray(0, 3 * nFaces), normal.array.subarray(0, 3 * nVertices));
    sendFirst(normal, 3 * nVertices);
    drawn.hasNormals = true;
  }
  if (materials.solid.flatShading !== flat) {
    materials.solid.flatShading = flat;
    materials.solid.needsUpdate = true;
  }
  makeRoomForWire(materials, wire);
  if (wire && !drawn.hasEdges) drawEdges(scene);
  if (scene.wire) scene.wire.visible = wire;
}

/** Draws the three edges of each face, so that those inside the surface are drawn twice. */
function drawEdges(scene) {
  const { room: { faces }, shown: { nFaces }, solid, materials, body } = scene;
  scene.wire ??= makeWire(solid.geometry, materials.wire);
  body.add(scene.wire);
  const { index } = scene.wire.geometry;
  let n = 0;
  for (let i = 0; i < 3 * nFaces; i += 3) {
    for (let k = 0; k < 3; k++) {
      index.array[n++] = faces[i + k];
      index.array[n++] = faces[i + (k + 1) % 3];
    }
  }
  sendFirst(index, n);
  scene.wire.geometry.setDrawRange(0, n);
  materials.wire.opacity = 1 - Math.sqrt(1 - wireOpacity(3 * nFaces));
  scene.drawn.hasEdges = true;
}

function makeWire(geometry, material) {
  const edges = new BufferGeometry();
  edges.setAttribute('position', geometry.attributes.position);
  edges.setIndex(dynamic(new Uint32Array(2 * geometry.index.count), 1));
  const wire = new LineSegments(edges, material);
  wire.frustumCulled = false;
  return wire;
}

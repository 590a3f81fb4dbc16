// A surface as three.js draws it: the mesh, its edges, its marks. The materials are shared by all of a page.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshPhongMaterial,
  Sphere,
} from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

/** Open, non-manifold and turned edges; the legend of the page has the same colours. */
const MARKS = ['#0a84ff', '#00a88f', '#6cae00'];

/** What surfaces, edges and marks look like. */
export function makeMaterials() {
  const solid = new MeshPhongMaterial({
    side: DoubleSide, shininess: 25, specular: 0x1c1c1c, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
  solid.onBeforeCompile = tintInside;
  const wire = new LineBasicMaterial({ transparent: true });
  const marks = MARKS.map((color) => new LineMaterial({
    color, linewidth: 4, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -100,
  }));
  return { solid, wire, marks, plain: new Color() };
}

/**
 * The inner side of a surface, seen through holes and where faces are turned over: red, dark blue under colours. Not where it
 * is seen edge on: at an outline the inner side is as near as the outer one and would show through.
 */
const INSIDE = `
#ifdef USE_MAP
  const vec3 inside = vec3(0.02, 0.04, 0.09);
#else
  const vec3 inside = vec3(0.42, 0.09, 0.07);
#endif
  float facing = abs(dot(normal, normalize(vViewPosition)));
  if (!gl_FrontFacing) diffuseColor.rgb = mix(diffuseColor.rgb, inside, smoothstep(0.05, 0.4, facing));`;

function tintInside(shader) {
  const after = '#include <normal_fragment_maps>';
  shader.fragmentShader = shader.fragmentShader.replace(after, `${after}${INSIDE}`);
}

/** Makes the objects of a surface, drawn as its `fine`; its edges and marks only when they are shown. */
export function makeModel(surface, radius, materials) {
  const geometry = geometryOf(surface.fine, radius);
  const group = new Group();
  const plain = new Mesh(geometry, materials.solid);
  group.add(plain);
  return {
    group, geometry, plain, surface, painted: null, marks: null, marking: null, wire: null, wiring: null, covered: null, covering: null,
  };
}

function geometryOf({ positions, normals, faces }, radius) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.boundingSphere = new Sphere(undefined, radius);
  return geometry;
}

/** Adds the surface of a model that distances are known on, where that is not the one that is drawn without them. */
export function addPainted(model, fine, materials) {
  if (model.painted) return;
  model.painted = new Mesh(geometryOf(fine, model.geometry.boundingSphere.radius), materials.solid);
  model.painted.visible = false;
  model.group.add(model.painted);
}

/** Adds the marked edges of a model, the first time that they are shown; everyone who asks waits until they are there. */
export function addMarks(model, materials) {
  model.marking ??= makeMarks(model, materials);
  return model.marking;
}

async function makeMarks(model, materials) {
  const { surface } = model;
  const marked = await surface.findMarked();
  model.marks = new Group();
  model.marks.visible = false;
  marked.forEach((edges, kind) => {
    if (edges.length > 0) model.marks.add(segments(surface.positions, edges, materials.marks[kind]));
  });
  model.group.add(model.marks);
}

function segments(positions, edges, material) {
  const ends = new Float32Array(3 * edges.length);
  edges.forEach((vertex, i) => ends.set(positions.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
  const object = new LineSegments2(new LineSegmentsGeometry().setPositions(ends), material);
  object.frustumCulled = false;
  return object;
}

/** Adds the edges of a model, the first time that they are shown; everyone who asks waits until they are there. */
export function addWire(model, materials) {
  model.wiring ??= makeWire(model, materials);
  return model.wiring;
}

async function makeWire(model, materials) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(model.surface.positions, 3));
  geometry.boundingSphere = model.geometry.boundingSphere;
  geometry.setIndex(new BufferAttribute(await model.surface.findEdges(), 1));
  model.wire = new LineSegments(geometry, wireOf(model, materials));
  model.wire.visible = false;
  model.group.add(model.wire);
}

/** The colour of all wires; the denser the mesh, the fainter its edges, so that the surface stays visible. */
function wireOf({ surface }, { wire }) {
  const material = wire.clone();
  material.color = wire.color;
  material.opacity = Math.min(0.6, Math.max(0.1, 0.6 * Math.sqrt(60_000 / surface.faces.length)));
  return material;
}

/** Number of the points that are drawn. */
export function nPoints(model) {
  return model.geometry.getAttribute('position').count;
}

/** Paints a model by the shares of the points that have distances, n_points x 2. */
export function setShares({ painted, plain }, shares) {
  (painted ?? plain).geometry.setAttribute('uv', new BufferAttribute(shares, 2));
}

/** Colours of surface and edges for a theme. */
export function setTheme(materials, { surface, wire }) {
  materials.plain = new Color(surface);
  materials.wire.color.set(wire);
}

/** Lets the edges win over the surface they lie on; without them, back faces would win over front faces at outlines. */
export function makeRoomForWire(materials, isShown) {
  materials.solid.polygonOffset = isShown;
}

/** Shows distances as colours, or the plain surface where `texture` is null. */
export function paint(materials, texture) {
  materials.solid.map = texture;
  materials.solid.color.copy(texture ? new Color(0xffffff) : materials.plain);
  materials.solid.needsUpdate = true;
}

/** Frees the graphics card of a model. */
export function disposeModel({ group, wire }) {
  group.traverse(({ geometry }) => geometry?.dispose());
  wire?.material.dispose();
}

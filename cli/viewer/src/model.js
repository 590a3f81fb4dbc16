// The model of a surface in three.js: mesh, edges and marks. All models of a page share the materials.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshPhongMaterial,
  Sphere,
} from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

/** Colours of open, non-manifold and turned edges; the page's legend has equal ones. */
const MARKS = ['#0a84ff', '#00a88f', '#6cae00'];

/** Creates the materials of surfaces, of the original and of results, and of edges and marks. */
export function makeMaterials() {
  const [solid, tinted] = [makeSolid(), makeSolid()];
  const wire = new LineBasicMaterial({ transparent: true });
  const marks = MARKS.map((color) => new LineMaterial({
    color, linewidth: 4, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -100,
  }));
  return { solid, tinted, wire, marks, plain: new Color(), tint: new Color() };
}

function makeSolid() {
  const solid = new MeshPhongMaterial({
    side: DoubleSide, shininess: 25, specular: 0x1c1c1c, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
  solid.onBeforeCompile = tintInside;
  return solid;
}

/**
 * Shader code that paints back faces, visible through holes and on turned faces: red, or dark blue under colours.
 *
 * Faces seen edge-on are left out: at an outline the back face is as near as the front face and would show through.
 */
const INSIDE = `
#ifdef USE_MAP
  const vec3 inside = vec3(0.02, 0.04, 0.09);
#else
  const vec3 inside = vec3(0.42, 0.09, 0.07);
#endif
  float facing = abs(dot(normal, normalize(vViewPosition)));
  if (!gl_FrontFacing) diffuseColor.rgb = mix(diffuseColor.rgb, inside, smoothstep(0.05, 0.4, facing));`;

/** Changes the shader of a surface so that back faces have another colour. */
export function tintInside(shader) {
  const after = '#include <normal_fragment_maps>';
  shader.fragmentShader = shader.fragmentShader.replace(after, `${after}${INSIDE}`);
}

/** Creates the objects of a surface of a material, drawn as its `fine` version; edges and marks follow when they are shown. */
export function makeModel(surface, radius, material) {
  const geometry = geometryOf(surface.fine, radius);
  const group = new Group();
  const plain = new Mesh(geometry, material);
  plain.castShadow = true;
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

/** Adds the surface on which distances are known, if it is not the one that is drawn without them. */
export function addPainted(model, fine) {
  if (model.painted) return;
  model.painted = new Mesh(geometryOf(fine, model.geometry.boundingSphere.radius), model.plain.material);
  model.painted.castShadow = true;
  model.painted.visible = false;
  model.group.add(model.painted);
}

/** Adds the marked edges of a model when they are first shown; all callers wait for them. */
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

/** Adds the edges of a model when they are first shown; all callers wait for them. */
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

/** Sets the colour of edges; edges of dense meshes are fainter, so that the surface stays visible. */
function wireOf({ surface }, { wire }) {
  const material = wire.clone();
  material.color = wire.color;
  material.opacity = wireOpacity(surface.faces.length);
  return material;
}

/** Returns the opacity of edges of a surface with a number of corners of faces. */
export function wireOpacity(nCorners) {
  return Math.min(0.6, Math.max(0.1, 0.6 * Math.sqrt(60_000 / nCorners)));
}

/** Paints a model by the distances of its points, as texture coordinates n_points x 2. */
export function setShares({ painted, plain }, shares) {
  (painted ?? plain).geometry.setAttribute('uv', new BufferAttribute(shares, 2));
}

/** Sets the colours of surface and edges for a theme. */
export function setTheme(materials, { surface, result, wire }) {
  materials.plain = new Color(surface);
  materials.tint = new Color(result);
  materials.wire.color.set(wire);
}

/** Moves the surface behind its edges in depth while they are shown; otherwise that would let back faces show at outlines. */
export function makeRoomForWire(materials, isShown) {
  for (const material of [materials.solid, materials.tinted]) material.polygonOffset = isShown;
}

/** Shows distances as colours, or the plain surface if `texture` is null. */
export function paint(materials, texture) {
  for (const [material, colour] of [[materials.solid, materials.plain], [materials.tinted, materials.tint]]) {
    material.map = texture;
    material.color.copy(texture ? new Color(0xffffff) : colour);
    material.needsUpdate = true;
  }
}

/** Frees the graphics memory of a model. */
export function disposeModel({ group, wire }) {
  group.traverse(({ geometry }) => geometry?.dispose());
  wire?.material.dispose();
}

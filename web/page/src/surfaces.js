// Meshes as the simplifier looks at them, made into the source of a scene.
//
// A mesh has `positions` (n x 3, from `origin`), `faces` (m x 3, in order of groups), and where the file has them `normals`, `uv`,
// `colors` (n x 4) and `groups`; its vertices are split at seams.

import { vertexNormals } from '../../../cli/viewer/src/surface.js';
import { findEdges } from './edges.js';
import { makeImages, numberOfImage } from './images.js';
import { weldVertices } from './weld.js';

/** Makes a source of meshes that are added as they come; `sharesOf(pair)` gives the distances of a pair, null where they are not known. */
export function makeSource(sharesOf) {
  const images = makeImages();
  const meshes = [];
  const covers = [];
  return {
    add: (mesh) => {
      covers.push(paintsOf(mesh, images));
      return meshes.push(mesh) - 1;
    },
    remove: (index) => { meshes[index] = covers[index] = null; },
    boxOf: (index) => boxOf(meshes[index]),
    surface: (index, place) => makeSurface(meshes[index], place),
    hasCover: (index) => Boolean(covers[index]),
    cover: async (index, surface) => coverOf(meshes[index], surface, covers[index]),
    image: async (index) => images.blobs[index],
    shares: async (pair) => sharesOf(pair),
  };
}

/** The lowest corner of a mesh and its sides. */
function boxOf({ positions, origin = [0, 0, 0] }) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let i = 0; i < positions.length; i++) {
    const axis = i % 3;
    low[axis] = Math.min(low[axis], positions[i]);
    high[axis] = Math.max(high[axis], positions[i]);
  }
  if (positions.length === 0) return { low: origin, sides: [0, 0, 0] };
  return { low: low.map((x, axis) => x + origin[axis]), sides: low.map((x, axis) => high[axis] - x) };
}

/** Welded for edges and for normals that the file does not have; drawn with the file's normals where it has them. */
async function makeSurface(mesh, { centre, scale }) {
  const { origin = [0, 0, 0] } = mesh;
  const shift = origin.map((x, axis) => (x - centre[axis]) * scale);
  const placed = mesh.positions.map((x, i) => x * scale + shift[i % 3]);
  mesh.weld ??= await weldVertices(mesh.positions);
  const { pointOf, firstOf } = mesh.weld;
  const positions = new Float32Array(3 * firstOf.length);
  firstOf.forEach((vertex, point) => {
    for (let axis = 0; axis < 3; axis++) positions[3 * point + axis] = placed[3 * vertex + axis];
  });
  const faces = mesh.faces.map((vertex) => pointOf[vertex]);
  const welded = mesh.normals ? null : await vertexNormals(positions, faces);
  const normals = mesh.normals ?? spread(welded, pointOf);
  let edges = null;
  const find = async () => { edges ??= findEdges(faces, firstOf.length); return edges; };
  return {
    positions, faces, normals, placed, fine: { positions: placed, normals, faces: mesh.faces },
    findEdges: async () => (await find()).all, findMarked: async () => (await find()).marked,
  };
}

/** The normals of points at their vertices. */
function spread(normals, pointOf) {
  const spreaded = new Float32Array(3 * pointOf.length);
  pointOf.forEach((point, vertex) => {
    for (let axis = 0; axis < 3; axis++) spreaded[3 * vertex + axis] = normals[3 * point + axis];
  });
  return spreaded;
}

/** What the groups of a mesh are painted with; null where nothing has a colour. */
function paintsOf({ faces, colors, uv, groups }, images) {
  const runs = groups?.length ? groups : [{ from: 0, faces: faces.length / 3 }];
  const paints = runs.map(({ color = [1, 1, 1, 1], image, wrap = ['repeat', 'repeat'] }) => ({
    image: uv ? numberOfImage(images, image) : null, wrap, color: color.slice(0, 3), coloured: Boolean(colors),
  }));
  const isPlain = paints.every(({ image, color }) => image === null && color.every((channel) => channel > 0.99));
  if (isPlain && !colors) return null;
  return { paints, runs: runs.map((run) => [3 * run.from, 3 * run.faces]) };
}

function coverOf({ positions, faces, uv, colors }, { placed, normals }, { paints, runs }) {
  const n = positions.length / 3;
  return {
    positions: placed, normals, faces, paints, runs,
    uvs: uv ?? new Float32Array(2 * n),
    colours: colors ? Float32Array.from({ length: 3 * n }, (_, i) => colors[4 * Math.floor(i / 3) + (i % 3)]) : null,
  };
}

// Creates the source of a scene from meshes of the package.
//
// A mesh has `positions` (n x 3, relative to `origin`), `faces` (m x 3, in order of groups), and if the file has them `normals`, `uv`,
// `colors` (n x 4) and `groups`; its vertices are split at seams.

import { withImages } from '../../../cli/viewer/src/finish.js';
import { vertexNormals } from '../../../cli/viewer/src/surface.js';
import { findEdges } from './edges.js';
import { makeImages, numberOfImage } from './images.js';
import { weldVertices } from './weld.js';

/** Creates a source to which meshes are added later; `sharesOf(pair)` returns the distances of a pair, or null if unknown. */
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

/** Returns the lowest corner and the sides of a mesh's bounding box. */
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

/** Creates a surface: welded to find edges and missing normals, and drawn with the file's normals if there are any. */
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

/** Copies the normals of points to their vertices. */
function spread(normals, pointOf) {
  const spreaded = new Float32Array(3 * pointOf.length);
  pointOf.forEach((point, vertex) => {
    for (let axis = 0; axis < 3; axis++) spreaded[3 * vertex + axis] = normals[3 * point + axis];
  });
  return spreaded;
}

/** Returns the paints of a mesh's groups, or null if there are no colours. */
function paintsOf({ faces, colors, uv, groups }, images) {
  const runs = groups?.length ? groups : [{ from: 0, faces: faces.length / 3 }];
  const numberOf = (image) => (uv ? numberOfImage(images, image) : null);
  const paints = runs.map(({ color = [1, 1, 1, 1], image, wrap = ['repeat', 'repeat'], finish }) => ({
    image: numberOf(image), wrap, color: color.slice(0, 3), coloured: Boolean(colors), finish: withImages(finish, numberOf),
  }));
  const isPlain = paints.every(({ image, color, finish }) => image === null && !finish && color.every((channel) => channel > 0.99));
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

// Decodes numbers to flat arrays: positions, normals, faces, marked edges, distances. Independent of three.js and the page.

import { readDifferences, readEach } from './numbers.js';
import { inSlices } from './slices.js';

/** Unpacks a mesh. `place` is {centre, scale}: positions are taken relative to the centre and scaled. */
export async function unpackSurface(layout, numbers, place) {
  const positions = await readPositions(layout, numbers, place);
  const faces = await readFaces(layout, numbers);
  const marked = [];
  for (const n of layout.marked) marked.push(await readEdges(n, numbers));
  const normals = await vertexNormals(positions, faces);
  return { positions, faces, normals, marked };
}

async function readPositions({ vertices, low, step }, numbers, { centre, scale }) {
  const positions = new Float32Array(3 * vertices);
  for (let axis = 0; axis < 3; axis++) {
    const from = (low[axis] - centre[axis]) * scale;
    await readDifferences(numbers, vertices, (steps, i) => { positions[3 * i + axis] = from + steps * step * scale; });
  }
  return positions;
}

/** Decodes faces; each corner is stored as its distance below the next unused vertex number. */
async function readFaces({ faces }, numbers) {
  const corners = new Uint32Array(3 * faces);
  let next = 0;
  await readEach(numbers, 3 * faces, (below, i) => {
    const vertex = next - below;
    if (below === 0) next++;
    corners[i] = vertex;
  });
  return corners;
}

async function readEdges(n, numbers) {
  const edges = new Uint32Array(2 * n);
  await readDifferences(numbers, 2 * n, (vertex, i) => { edges[i] = vertex; });
  return edges;
}

/** Decodes distances of n points as texture coordinates n x 2: shares of the largest, stored as square roots. */
export async function unpackShares(n, numbers) {
  const shares = new Float32Array(2 * n).fill(0.5);
  await readDifferences(numbers, n, (root, i) => { shares[2 * i] = (root / 65535) ** 2; });
  return shares;
}

/**
 * What covers a surface: wedges, which are its vertices with texture coordinates, colours and normals, and its faces over them, those of
 * a paint behind each other; `runs` says where those of each paint begin in `faces` and how long they are.
 */
export async function unpackCover({ wedges, low, step, coloured, shaded, paints }, numbers, { positions, normals, faces }) {
  const cover = {
    positions: new Float32Array(3 * wedges), normals: new Float32Array(3 * wedges), uvs: new Float32Array(2 * wedges),
    colours: coloured ? new Float32Array(3 * wedges) : null,
  };
  await readDifferences(numbers, wedges, (vertex, i) => {
    for (let axis = 0; axis < 3; axis++) {
      cover.positions[3 * i + axis] = positions[3 * vertex + axis];
      cover.normals[3 * i + axis] = normals[3 * vertex + axis];
    }
  });
  for (let axis = 0; axis < 2; axis++) {
    await readDifferences(numbers, wedges, (steps, i) => { cover.uvs[2 * i + axis] = low[axis] + steps * step[axis]; });
  }
  if (shaded) await readNormals(numbers, cover.normals);
  for (let channel = 0; coloured && channel < 3; channel++) {
    await readDifferences(numbers, wedges, (value, i) => { cover.colours[3 * i + channel] = value / 4095; });
  }
  const paintOf = new Uint32Array(faces.length / 3);
  await readDifferences(numbers, paintOf.length, (paint, face) => { paintOf[face] = paint; });
  const corners = await readFaces({ faces: paintOf.length }, numbers);
  return { ...cover, ...byPaint(corners, paintOf, Math.max(paints.length, 1)) };
}

/** Steps of a normal along each side of the square onto which the octahedron unfolds. */
const NORMAL_STEPS = 2047;

/** Decodes stored normals; where the file has none, the given ones stay. */
async function readNormals(numbers, normals) {
  const n = normals.length / 3;
  const sides = [new Float32Array(n), new Float32Array(n)];
  for (const side of sides) await readDifferences(numbers, n, (steps, i) => { side[i] = (2 * steps) / NORMAL_STEPS - 1; });
  for (let i = 0; i < n; i++) {
    const [a, b] = [sides[0][i], sides[1][i]];
    if (a > 1) continue;
    const z = 1 - Math.abs(a) - Math.abs(b);
    const fold = Math.max(-z, 0);
    const [x, y] = [a - Math.sign(a) * fold, b - Math.sign(b) * fold];
    const length = Math.hypot(x, y, z);
    normals.set([x / length, y / length, z / length], 3 * i);
  }
}

/** Sorts faces by paint, and returns the range of each paint in corners. */
function byPaint(corners, paintOf, nPaints) {
  const runs = Array.from({ length: nPaints }, () => [0, 0]);
  for (const paint of paintOf) runs[paint][1] += 3;
  runs.reduce((from, run) => { run[0] = from; return from + run[1]; }, 0);
  const faces = new Uint32Array(corners.length);
  const next = runs.map(([from]) => from);
  paintOf.forEach((paint, face) => {
    faces.set(corners.subarray(3 * face, 3 * face + 3), next[paint]);
    next[paint] += 3;
  });
  return { faces, runs };
}

/** Computes area-weighted vertex normals. */
export async function vertexNormals(positions, faces) {
  const normals = new Float32Array(positions.length);
  await inSlices(faces.length / 3, (from, to) => addNormals(positions, faces, normals, from, to));
  await inSlices(normals.length / 3, (from, to) => normalise(normals, from, to));
  return normals;
}

/** Computes area-weighted vertex normals at once into an array of the same length as the positions. */
export function fillNormals(positions, faces, normals) {
  normals.fill(0);
  addNormals(positions, faces, normals, 0, faces.length / 3);
  normalise(normals, 0, normals.length / 3);
}

function addNormals(positions, faces, normals, from, to) {
  for (let i = 3 * from; i < 3 * to; i += 3) {
    const [a, b, c] = [3 * faces[i], 3 * faces[i + 1], 3 * faces[i + 2]];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    normals[a] += x; normals[a + 1] += y; normals[a + 2] += z;
    normals[b] += x; normals[b + 1] += y; normals[b + 2] += z;
    normals[c] += x; normals[c + 1] += y; normals[c + 2] += z;
  }
}

function normalise(normals, from, to) {
  for (let i = 3 * from; i < 3 * to; i += 3) {
    const [x, y, z] = [normals[i], normals[i + 1], normals[i + 2]];
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    normals[i] /= length; normals[i + 1] /= length; normals[i + 2] /= length;
  }
}

/** Returns the ends of every edge, once: an unmarked edge has two faces of opposite directions. */
export async function allEdges({ faces, marked }) {
  const edges = new Uint32Array(2 * faces.length + marked.reduce((sum, list) => sum + list.length, 0));
  let n = 0;
  const add = (a, b) => { edges[n++] = a; edges[n++] = b; };
  await inSlices(faces.length / 3, (from, to) => {
    for (let i = 3 * from; i < 3 * to; i += 3) {
      const a = faces[i], b = faces[i + 1], c = faces[i + 2];
      if (a < b) add(a, b);
      if (b < c) add(b, c);
      if (c < a) add(c, a);
    }
  });
  for (const list of marked) for (let i = 0; i < list.length; i += 2) add(list[i], list[i + 1]);
  return edges.subarray(0, n);
}

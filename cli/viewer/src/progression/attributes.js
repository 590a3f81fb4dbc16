// Attributes at the corners of a level: those of the mesh at its closest points.

import { componentsOf } from './components.js';
import { ranksOf, sourceFacesOf } from './level.js';

/** Squared distances of candidates that count as equal, over the least; then the face that is turned like the level's decides. */
const ALIKE = 1.02;

/**
 * Returns for each corner of a level, as `mesh` {positions, faces} of its coordinates has it, the values of some channels behind each
 * other. A vertex of a level stands for those that were merged into it, so the faces around these are searched; seams separate them.
 */
export function cornerValues(progression, level, mesh, channels) {
  const width = channels.reduce((sum, channel) => sum + channel.width, 0);
  const values = new Float32Array(width * mesh.faces.length);
  if (width === 0) return { width, values };
  const original = originalOf(progression);
  const around = facesAround(progression, level);
  const [ranks, sources] = [ranksOf(progression, level), sourceFacesOf(progression, level)];
  // Charts are components of wedges.
  const nWedges = original.wedges.reduce((most, wedge) => Math.max(most, wedge + 1), 0);
  const charts = componentsOf(nWedges, original.wedges);
  sources.forEach((source, face) => {
    const corners = mesh.faces.subarray(3 * face, 3 * face + 3);
    const normal = normalOf(mesh.positions, corners);
    const chart = charts[original.wedges[3 * source]];
    corners.forEach((vertex, k) => {
      const rank = ranks[vertex];
      const candidates = around.items.subarray(around.starts[rank], around.starts[rank + 1]);
      const isNear = (other) => charts[original.wedges[3 * other]] === chart;
      const point = mesh.positions.subarray(3 * vertex, 3 * vertex + 3);
      const found = closestFace(original, candidates, isNear, point, normal) ?? { face: source, weights: [1 / 3, 1 / 3, 1 / 3] };
      blend(original.wedges, found, channels, values, width * (3 * face + k));
    });
  });
  return { width, values };
}

/** Returns the mesh of a progression with its wedges. */
function originalOf({ mesh: { positions, faces }, attributes: { wedges } }) {
  return { positions, faces, wedges };
}

/** Lists for each rank of a level the faces of the mesh that have a vertex which was merged into it. */
function facesAround({ sequence: { n, parents, vertices }, surface }, level) {
  const ancestors = new Uint32Array(n);
  for (let rank = 0; rank < n; rank++) ancestors[rank] = rank < level.n ? rank : ancestors[parents[rank]];
  const ofVertex = new Uint32Array(n);
  vertices.forEach((vertex, rank) => { ofVertex[vertex] = ancestors[rank]; });
  const visit = (add) => {
    for (let i = 0; i < surface.faces.length; i += 3) {
      const [a, b, c] = [ofVertex[surface.faces[i]], ofVertex[surface.faces[i + 1]], ofVertex[surface.faces[i + 2]]];
      add(a, i / 3);
      if (b !== a) add(b, i / 3);
      if (c !== a && c !== b) add(c, i / 3);
    }
  };
  const starts = new Uint32Array(level.n + 1);
  visit((rank) => starts[rank + 1]++);
  for (let rank = 0; rank < level.n; rank++) starts[rank + 1] += starts[rank];
  const [items, next] = [new Uint32Array(starts[level.n]), starts.slice()];
  visit((rank, face) => { items[next[rank]++] = face; });
  return { starts, items };
}

/** Returns the closest candidate to a point and the weights of its corners there; of nearly equal ones that turned most like a normal. */
function closestFace({ positions, faces }, candidates, isNear, point, normal) {
  let [best, least] = [null, Infinity];
  const found = [];
  for (const face of candidates) {
    if (!isNear(face)) continue;
    const corners = faces.subarray(3 * face, 3 * face + 3);
    const { weights, distance } = closestWeights(positions, corners, point);
    least = Math.min(least, distance);
    found.push({ face, weights, distance });
  }
  for (const candidate of found) {
    if (candidate.distance > ALIKE * least) continue;
    const other = normalOf(positions, faces.subarray(3 * candidate.face, 3 * candidate.face + 3));
    const turn = (other[0] * normal[0] + other[1] * normal[1] + other[2] * normal[2]) / (Math.hypot(...other) || 1);
    if (best === null || turn > best.turn) best = { ...candidate, turn };
  }
  return best;
}

/** Returns the weights of a triangle's corners at its closest point (Ericson 2005, Real-Time Collision Detection, 5.1.5), and its squared distance. */
export function closestWeights(positions, [a, b, c], point) {
  const read = (v) => [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
  const minus = (p, q) => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const [p, q, r] = [read(a), read(b), read(c)];
  const [pq, pr] = [minus(q, p), minus(r, p)];
  const [d1, d2] = [dot(pq, minus(point, p)), dot(pr, minus(point, p))];
  const [d3, d4] = [dot(pq, minus(point, q)), dot(pr, minus(point, q))];
  const [d5, d6] = [dot(pq, minus(point, r)), dot(pr, minus(point, r))];
  const [va, vb, vc] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
  const weights = weightsAt([d1, d2, d3, d4, d5, d6], [va, vb, vc]);
  const at = [0, 1, 2].map((axis) => weights[0] * p[axis] + weights[1] * q[axis] + weights[2] * r[axis]);
  const off = minus(point, at);
  return { weights, distance: dot(off, off) };
}

function weightsAt([d1, d2, d3, d4, d5, d6], [va, vb, vc]) {
  if (d1 <= 0 && d2 <= 0) return [1, 0, 0];
  if (d3 >= 0 && d4 <= d3) return [0, 1, 0];
  if (d6 >= 0 && d5 <= d6) return [0, 0, 1];
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return [1 - d1 / (d1 - d3), d1 / (d1 - d3), 0];
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return [1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)];
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const share = (d4 - d3) / (d4 - d3 + (d5 - d6));
    return [0, 1 - share, share];
  }
  const sum = va + vb + vc;
  return sum > 0 ? [va / sum, vb / sum, vc / sum] : [1 / 3, 1 / 3, 1 / 3];
}

function normalOf(positions, [a, b, c]) {
  const edge = (from, to) => [0, 1, 2].map((axis) => positions[3 * to + axis] - positions[3 * from + axis]);
  const [[ux, uy, uz], [vx, vy, vz]] = [edge(a, b), edge(a, c)];
  return [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
}

/** Writes the values of channels at a point of a face. */
function blend(wedges, { face, weights }, channels, into, at) {
  for (const { width, values } of channels) {
    for (let i = 0; i < width; i++) {
      into[at++] = weights.reduce((sum, weight, k) => sum + (weight === 0 ? 0 : weight * values[width * wedges[3 * face + k] + i]), 0);
    }
  }
}

// Decodes pages: arrays for drawing, of all clusters of a page.

import { check, entriesOf } from './container.js';

/**
 * Decodes the bytes of a page: positions and corners of all clusters one after the other, normals if the file has them, and for
 * each vertex `facts`, its cluster's number, level, and mean side of triangles. `firsts` has the first corner of each cluster.
 */
export function decodePage(hierarchy, page, bytes) {
  const { header, clusters } = hierarchy;
  const contents = entriesOf(hierarchy.contents, page);
  const sum = (column) => contents.reduce((total, cluster) => total + column[cluster], 0);
  const [nVertices, nFaces] = [sum(clusters.nVertices), sum(clusters.nFaces)];
  const normalsAt = placeOfNormals(header.channels);
  const decoded = {
    contents,
    positions: new Float32Array(3 * nVertices),
    normals: normalsAt === null ? null : new Float32Array(3 * nVertices),
    facts: new Float32Array(3 * nVertices),
    corners: nVertices > 0xffff ? new Uint32Array(3 * nFaces) : new Uint16Array(3 * nFaces),
    firsts: new Uint32Array(contents.length + 1),
  };
  let [vertex, corner] = [0, 0];
  contents.forEach((cluster, i) => {
    const [offset, n, nCorners] = [clusters.offsets[cluster], clusters.nVertices[cluster], 3 * clusters.nFaces[cluster]];
    const floats = (at) => new Float32Array(bytes.buffer, offset + 4 * n * at, 3 * n);
    check(floats(0).every(Number.isFinite), 'a position that is not finite');
    decoded.positions.set(floats(0), 3 * vertex);
    decoded.normals?.set(floats(normalsAt), 3 * vertex);
    const corners = bytes.subarray(offset + cornersAt(header, n, nCorners / 3)).subarray(0, nCorners);
    corners.forEach((place, k) => {
      check(place < n, 'a triangle with a corner beyond its cluster');
      decoded.corners[corner + k] = vertex + place;
    });
    const facts = [cluster, clusters.levels[cluster], meanSide(floats(0), corners)];
    for (let v = vertex; v < vertex + n; v++) decoded.facts.set(facts, 3 * v);
    vertex += n;
    corner += nCorners;
    decoded.firsts[i + 1] = corner;
  });
  return decoded;
}

/** Returns how many numbers per vertex precede the normals; null if there are none. */
function placeOfNormals(channels) {
  const index = channels.findIndex(({ role, width }) => role === 'normal' && width === 3);
  return index < 0 ? null : channels.slice(0, index).reduce((sum, { width }) => sum + width, 3);
}

function cornersAt({ channels, has_face_groups: hasFaceGroups }, nVertices, nFaces) {
  return 4 * nVertices * channels.reduce((sum, { width }) => sum + width, 3) + (hasFaceGroups ? 4 * nFaces : 0);
}

/** Returns the side of equilateral triangles of the mean area. */
function meanSide(positions, corners) {
  let twiceArea = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
    const [ux, uy, uz] = [0, 1, 2].map((axis) => positions[b + axis] - positions[a + axis]);
    const [vx, vy, vz] = [0, 1, 2].map((axis) => positions[c + axis] - positions[a + axis]);
    twiceArea += Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
  }
  const meanArea = twiceArea / 2 / Math.max(corners.length / 3, 1);
  return Math.sqrt((4 / Math.sqrt(3)) * meanArea);
}

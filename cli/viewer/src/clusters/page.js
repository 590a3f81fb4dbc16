// Decodes pages: arrays for drawing, of all clusters of a page.

import { check, entriesOf } from './container.js';

/** Faces without a choice of paints. */
const ONE_PAINT = { nPaints: 1, paintOf: () => 0, isVUp: false };

/**
 * Decodes the bytes of a page: positions and corners of all clusters one after the other, normals and texture coordinates if the file
 * has them, and for each vertex `facts`, its cluster's number, level, and mean side of triangles. The corners of a cluster are sorted by
 * paint, which `paintOf` says of a material's number; `isVUp` says that v grows upwards; `firsts` has the first corner of each cluster and paint.
 */
export function decodePage(hierarchy, page, bytes, { nPaints, paintOf, isVUp } = ONE_PAINT) {
  const { header, clusters } = hierarchy;
  const contents = entriesOf(hierarchy.contents, page);
  const sum = (column) => contents.reduce((total, cluster) => total + column[cluster], 0);
  const [nVertices, nFaces] = [sum(clusters.nVertices), sum(clusters.nFaces)];
  const [normalsAt, uvsAt] = [placeOf(header.channels, 'normal', 3), placeOf(header.channels, 'uv', 2)];
  const decoded = {
    contents,
    positions: new Float32Array(3 * nVertices),
    normals: normalsAt === null ? null : new Float32Array(3 * nVertices),
    uvs: uvsAt === null ? null : new Float32Array(2 * nVertices),
    facts: new Float32Array(3 * nVertices),
    corners: nVertices > 0xffff ? new Uint32Array(3 * nFaces) : new Uint16Array(3 * nFaces),
    firsts: new Uint32Array(nPaints * contents.length + 1),
  };
  let [vertex, corner] = [0, 0];
  contents.forEach((cluster, i) => {
    const [offset, n, nCorners] = [clusters.offsets[cluster], clusters.nVertices[cluster], 3 * clusters.nFaces[cluster]];
    const floats = (at, width = 3) => new Float32Array(bytes.buffer, offset + 4 * n * at, width * n);
    check(floats(0).every(Number.isFinite), 'a position that is not finite');
    decoded.positions.set(floats(0), 3 * vertex);
    decoded.normals?.set(floats(normalsAt), 3 * vertex);
    decoded.uvs?.set(floats(uvsAt, 2).map((value, k) => (isVUp && k % 2 === 1 ? 1 - value : value)), 2 * vertex);
    const corners = bytes.subarray(offset + cornersAt(header, n, nCorners / 3)).subarray(0, nCorners);
    check(corners.every((place) => place < n), 'a triangle with a corner beyond its cluster');
    const paints = paintsOf(new DataView(bytes.buffer, offset, header.page_size - offset), header, n, nCorners / 3, paintOf);
    for (let paint = 0; paint < nPaints; paint++) {
      paints.forEach((other, face) => {
        if (other !== paint) return;
        for (let k = 3 * face; k < 3 * face + 3; k++) decoded.corners[corner++] = vertex + corners[k];
      });
      decoded.firsts[i * nPaints + paint + 1] = corner;
    }
    const facts = [cluster, clusters.levels[cluster], meanSide(floats(0), corners)];
    for (let v = vertex; v < vertex + n; v++) decoded.facts.set(facts, 3 * v);
    vertex += n;
  });
  return decoded;
}

/** Returns how many numbers per vertex precede the first channel of a role and width; null if there is none. */
function placeOf(channels, wanted, wantedWidth) {
  const index = channels.findIndex(({ role, width }) => role === wanted && width === wantedWidth);
  return index < 0 ? null : channels.slice(0, index).reduce((sum, { width }) => sum + width, 3);
}

function materialsAt({ channels }, nVertices) {
  return 4 * nVertices * channels.reduce((sum, { width }) => sum + width, 3);
}

function cornersAt(header, nVertices, nFaces) {
  return materialsAt(header, nVertices) + (header.has_face_groups ? 4 * nFaces : 0);
}

/** Returns the paint of each triangle of a cluster, whose bytes a view begins with. */
function paintsOf(view, header, nVertices, nFaces, paintOf) {
  const begin = materialsAt(header, nVertices);
  return Array.from({ length: nFaces }, (_, face) => paintOf(header.has_face_groups ? view.getUint32(begin + 4 * face, true) : 0));
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

// Meshes of loaded pages: one per page, whose corners are those of the clusters that are drawn.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh } from 'three';
import { sendFirst } from '../buffers.js';

/** Creates the mesh of a decoded page, with nothing to draw. */
export function makePageMesh({ contents, positions, normals, facts, corners, firsts }, material) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  if (normals) geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setAttribute('facts', new BufferAttribute(facts, 3));
  geometry.setIndex(new BufferAttribute(corners.slice(), 1).setUsage(DynamicDrawUsage));
  geometry.setDrawRange(0, 0);
  geometry.computeBoundingSphere();
  const mesh = new Mesh(geometry, material);
  mesh.visible = false;
  return { mesh, contents, corners, firsts, drawn: new Uint8Array(contents.length) };
}

/** Draws those clusters of a page that `isDrawn` names; returns how many changed. */
export function setDrawn(page, isDrawn) {
  let nChanged = 0;
  page.contents.forEach((cluster, i) => {
    const drawn = isDrawn(cluster) ? 1 : 0;
    if (page.drawn[i] !== drawn) nChanged++;
    page.drawn[i] = drawn;
  });
  if (nChanged > 0) fillIndex(page);
  return nChanged;
}

function fillIndex({ mesh, corners, firsts, drawn }) {
  const { index } = mesh.geometry;
  let n = 0;
  drawn.forEach((isDrawn, i) => {
    if (!isDrawn) return;
    index.array.set(corners.subarray(firsts[i], firsts[i + 1]), n);
    n += firsts[i + 1] - firsts[i];
  });
  sendFirst(index, n);
  mesh.geometry.setDrawRange(0, n);
  mesh.visible = n > 0;
}

/** Returns the corners' positions of what is drawn of a page, 9 numbers per triangle. */
export function drawnTriangles({ geometry }) {
  const { index, drawRange, attributes: { position } } = geometry;
  const corners = Array.from(index.array.subarray(0, drawRange.count));
  return corners.flatMap((v) => [...position.array.subarray(3 * v, 3 * v + 3)]);
}

// Meshes of loaded pages: one per page, whose corners are those of the clusters that are drawn.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh } from 'three';
import { sendFirst } from '../buffers.js';

/** Creates the mesh of a decoded page, with nothing to draw. */
export function makePageMesh({ contents, positions, normals, uvs, facts, corners, firsts }, materials) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  if (normals) geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  if (uvs) geometry.setAttribute('uv', new BufferAttribute(uvs, 2));
  geometry.setAttribute('facts', new BufferAttribute(facts, 3));
  geometry.setIndex(new BufferAttribute(corners.slice(), 1).setUsage(DynamicDrawUsage));
  geometry.setDrawRange(0, 0);
  geometry.computeBoundingSphere();
  const mesh = new Mesh(geometry, materials);
  mesh.visible = false;
  return {
    mesh, contents, corners, firsts, nPaints: materials.length,
    chosen: new Uint8Array(contents.length), drawn: new Uint8Array(contents.length),
  };
}

/** Chooses those clusters of a page that `isChosen` names, and draws those in the view; returns how many changed. */
export function setDrawn(page, isChosen, isInView) {
  let [nChanged, nRedrawn] = [0, 0];
  page.contents.forEach((cluster, i) => {
    const chosen = isChosen(cluster) ? 1 : 0;
    const drawn = chosen === 1 && isInView(cluster) ? 1 : 0;
    if (page.chosen[i] !== chosen) nChanged++;
    if (page.drawn[i] !== drawn) nRedrawn++;
    page.chosen[i] = chosen;
    page.drawn[i] = drawn;
  });
  if (nRedrawn > 0) fillIndex(page);
  return nChanged;
}

/** Writes the corners of what is drawn, those of a paint behind each other. */
function fillIndex({ mesh, corners, firsts, drawn, nPaints }) {
  const { geometry } = mesh;
  let n = 0;
  geometry.clearGroups();
  for (let paint = 0; paint < nPaints; paint++) {
    const begin = n;
    drawn.forEach((isDrawn, i) => {
      const slot = i * nPaints + paint;
      if (!isDrawn || firsts[slot] === firsts[slot + 1]) return;
      geometry.index.array.set(corners.subarray(firsts[slot], firsts[slot + 1]), n);
      n += firsts[slot + 1] - firsts[slot];
    });
    if (n > begin) geometry.addGroup(begin, n - begin, paint);
  }
  sendFirst(geometry.index, n);
  geometry.setDrawRange(0, n);
  mesh.visible = n > 0;
}

/** Returns the corners' positions of what is drawn of a page, 9 numbers per triangle. */
export function drawnTriangles({ geometry }) {
  const { index, drawRange, attributes: { position } } = geometry;
  const corners = Array.from(index.array.subarray(0, drawRange.count));
  return corners.flatMap((v) => [...position.array.subarray(3 * v, 3 * v + 3)]);
}

// A transform for glTF-Transform: makes the meshes of a document lighter in place, with all that their vertices carry.

import { readGoal } from './goal.js';
import { simplifyParts } from './parts.js';
import { isOfTriangles, lightenPart, readPart, writePart } from './primitive.js';

/** Makes the meshes of a document lighter. `types/gltf-transform.d.ts` documents it. */
export function neuralSimplify(options = {}) {
  const goal = readGoal(options);
  const { progress, signal, worker } = options;

  async function neuralSimplify(document) {
    const meshes = meshesOf(document);
    const total = meshes.reduce((sum, { nFaces }) => sum + nFaces, 0);
    const chosen = [];
    let done = 0;
    for (const { parts, nFaces } of meshes) {
      const listener = progress && ((share) => progress((done + share * nFaces) / total));
      chosen.push(await simplifyParts(parts, goal, { progress: listener, signal, worker }));
      done += nFaces;
    }
    // Nothing is written before all is there, so that a failure leaves the document as it is.
    meshes.forEach(({ mesh, parts }, i) => writeMesh(document, mesh, parts, chosen[i]));
  }
  return neuralSimplify;
}

/** Each mesh with its primitives of triangles, each primitive once. */
function meshesOf(document) {
  const seen = new Set();
  const meshes = document.getRoot().listMeshes().map((mesh) => {
    const primitives = mesh.listPrimitives().filter((primitive) => !seen.has(primitive));
    primitives.forEach((primitive) => seen.add(primitive));
    const triangles = primitives.filter(isOfTriangles);
    if (triangles.length < primitives.length) {
      const others = primitives.length - triangles.length;
      document.getLogger().warn(`neuralSimplify: ${others} primitives of "${mesh.getName()}" are not triangles and stay unchanged`);
    }
    const parts = triangles.map(readPart);
    return { mesh, parts, nFaces: parts.reduce((sum, { indices }) => sum + indices.length / 3, 0) };
  });
  return meshes.filter(({ nFaces }) => nFaces > 0);
}

/** Writes what remains of the primitives of a mesh; an empty mesh leaves the document. */
function writeMesh(document, mesh, parts, chosen) {
  // All is read before the first is written, as a part may take vertices from another.
  const light = parts.map((_, i) => lightenPart(document, parts, i, chosen));
  parts.forEach(({ primitive }, i) => writePart(document, mesh, primitive, light[i]));
  if (mesh.listPrimitives().length === 0) mesh.dispose();
}

// Simplifies the meshes of a glTF-Transform document in place, with all vertex attributes.

import { readGoal } from './goal.js';
import { simplifyParts } from './parts.js';
import { isOfTriangles, lightenPart, readPart, writePart } from './primitive.js';

/** Simplifies the meshes of a document; see `types/gltf-transform.d.ts`. */
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
    // The document is written only after all meshes are simplified, so a failure leaves it unchanged.
    meshes.forEach(({ mesh, parts }, i) => writeMesh(document, mesh, parts, chosen[i]));
  }
  return neuralSimplify;
}

/** Lists the meshes with their triangle primitives, each primitive once. */
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

/** Writes the simplified primitives of a mesh, and removes an empty mesh from the document. */
function writeMesh(document, mesh, parts, chosen) {
  // All parts are read before the first is written, as a part may take vertices from another.
  const light = parts.map((_, i) => lightenPart(document, parts, i, chosen));
  parts.forEach(({ primitive }, i) => writePart(document, mesh, primitive, light[i]));
  if (mesh.listPrimitives().length === 0) mesh.dispose();
}

// Prepares a comparison for the scene: the measured surfaces, and the colours of distances.

import { refined } from '../../../cli/viewer/src/refine.js';
import { vertexNormals } from '../../../cli/viewer/src/surface.js';
import { scaleOf } from './scale.js';

/**
 * The shares of a pair as a source gives them, and where the colours end. `surfaces` are those of original and result with the
 * `steps` along their sides at which distances were measured; `origins` are those of both meshes.
 */
export async function paintPair({ surfaces, distances: { ofOriginal, ofResult } }, origins, place) {
  const origin = origins.find((one) => one.some((x) => x !== 0)) ?? [0, 0, 0];
  const [original, result] = await Promise.all(surfaces.map((surface) => fineSurface(surface, origin, place)));
  const scale = scaleOf([{ values: ofOriginal, mesh: original }, { values: ofResult, mesh: result }]);
  const shares = { surfaces: [original, result], ofOriginal: sharesOf(ofOriginal, scale.max), ofResult: sharesOf(ofResult, scale.max) };
  return { scale, shares };
}

/** Returns a surface in place, cut as finely as distances were measured. */
async function fineSurface({ positions, faces, steps }, origin, { centre, scale }) {
  const shift = origin.map((x, axis) => (x - centre[axis]) * scale);
  const placed = positions.map((x, i) => x * scale + shift[i % 3]);
  const surface = { positions: placed, faces, normals: await vertexNormals(placed, faces) };
  return steps > 1 ? refined(surface, steps) : surface;
}

/** Returns distances as texture coordinates, n x 2: shares of the largest. */
function sharesOf(distances, max) {
  const shares = new Float32Array(2 * distances.length).fill(0.5);
  distances.forEach((distance, i) => { shares[2 * i] = max > 0 ? distance / max : 0; });
  return shares;
}

// Cuts faces into smaller similar ones, so that colours can vary within a large face. The surface is unchanged.

import { inSlices } from './slices.js';

/** Returns a surface whose faces are cut into `steps` along each side; positions and normals are interpolated. */
export async function refined({ positions, normals, faces }, steps) {
  const grid = gridOf(steps);
  const nFaces = faces.length / 3;
  const fine = {
    positions: new Float32Array(3 * nFaces * grid.weights.length),
    normals: new Float32Array(3 * nFaces * grid.weights.length),
    faces: new Uint32Array(nFaces * grid.corners.length),
  };
  await inSlices(nFaces, (from, to) => {
    for (let face = from; face < to; face++) {
      const corners = [3 * faces[3 * face], 3 * faces[3 * face + 1], 3 * faces[3 * face + 2]];
      const first = face * grid.weights.length;
      blend(positions, corners, grid.weights, fine.positions, 3 * first);
      blend(normals, corners, grid.weights, fine.normals, 3 * first);
      grid.corners.forEach((corner, i) => { fine.faces[face * grid.corners.length + i] = first + corner; });
    }
  });
  return fine;
}

/** Returns the barycentric weights of the points of a face, row by row from its first corner, and the small faces between them. */
function gridOf(steps) {
  const weights = [];
  const corners = [];
  const at = (i, j) => i * (steps + 1) - (i * (i - 1)) / 2 + j;
  for (let i = 0; i <= steps; i++) {
    for (let j = 0; i + j <= steps; j++) {
      weights.push([(steps - i - j) / steps, i / steps, j / steps]);
      if (i + j < steps) corners.push(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j < steps - 1) corners.push(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return { weights, corners };
}

function blend(values, [a, b, c], weights, out, at) {
  for (const [u, v, w] of weights) {
    for (let x = 0; x < 3; x++) out[at++] = u * values[a + x] + v * values[b + x] + w * values[c + x];
  }
}

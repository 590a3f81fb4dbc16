// Reads a mesh that the tests of the library have.

import { readFileSync } from 'node:fs';

/** Returns the cow of the tests of the library, from binary PLY of doubles. */
export function spot() {
  const file = readFileSync(new URL('../../../tests/meshes/spot.ply', import.meta.url));
  const header = file.subarray(0, file.indexOf('end_header\n')).toString();
  const [nVertices, nFaces] = ['vertex', 'face'].map((name) => Number(header.match(`element ${name} (\\d+)`)[1]));
  const start = header.length + 'end_header\n'.length;
  const positions = Float32Array.from({ length: 3 * nVertices }, (_, i) => file.readDoubleLE(start + 8 * i));
  const corner = (i) => file.readInt32LE(start + 24 * nVertices + 13 * Math.floor(i / 3) + 1 + 4 * (i % 3));
  return { positions, faces: Uint32Array.from({ length: 3 * nFaces }, (_, i) => corner(i)) };
}

// Reads the binary PLY files that the program writes: positions, and triangles.

import { readFileSync } from 'node:fs';

const END = 'end_header\n';
/** Bytes of a triangle: its number of corners, and their vertices. */
const FACE = 13;

/** Returns positions, as single precision holds them, and faces of a file, 3 numbers each. */
export function readPly(path) {
  const bytes = readFileSync(path);
  const begin = bytes.indexOf(END) + END.length;
  const header = bytes.toString('latin1', 0, begin);
  const [nVertices, nFaces] = ['vertex', 'face'].map((name) => Number(header.match(`element ${name} (\\d+)`)[1]));
  const view = new DataView(bytes.buffer, bytes.byteOffset + begin);
  const isDouble = header.includes('property double x');
  const stride = isDouble ? 24 : 12;
  const number = (i) => (isDouble ? view.getFloat64(8 * i, true) : view.getFloat32(4 * i, true));
  const corner = (i) => view.getInt32(stride * nVertices + FACE * Math.floor(i / 3) + 1 + 4 * (i % 3), true);
  return {
    positions: Float32Array.from({ length: 3 * nVertices }, (_, i) => number(i)),
    faces: Uint32Array.from({ length: 3 * nFaces }, (_, i) => corner(i)),
  };
}

// Files of a level: binary PLY and STL, OBJ, and GLB. An exported level is that of exported.js.

import { writeGlb } from './glb.js';

/** Formats by the ending of their files; each function returns the bytes, or the text, of a level. */
export const FORMATS = { glb: writeGlb, ply: writePly, obj: writeObj, stl: writeStl };

const isAtOrigin = ({ origin }) => origin.every((x) => x === 0);

/** Returns the coordinates of a vertex in the file. */
function pointOf({ positions, origin }, vertex) {
  return [0, 1, 2].map((axis) => positions[3 * vertex + axis] + origin[axis]);
}

function valuesAt({ width, values }, vertex) {
  return values.subarray(width * vertex, width * (vertex + 1));
}

function writePly(level) {
  const { positions, faces, normal, uv, colour } = level;
  const [nVertices, nFaces] = [positions.length / 3, faces.length / 3];
  const kind = isAtOrigin(level) ? 'float' : 'double';
  const names = [...(normal ? ['nx', 'ny', 'nz'] : []), ...(uv ? ['s', 't'] : [])];
  const colours = ['red', 'green', 'blue', 'alpha'].slice(0, colour?.width ?? 0);
  const header = [
    'ply', 'format binary_little_endian 1.0', `element vertex ${nVertices}`,
    ...['x', 'y', 'z'].map((axis) => `property ${kind} ${axis}`), ...names.map((name) => `property float ${name}`),
    ...colours.map((name) => `property uchar ${name}`), `element face ${nFaces}`, 'property list uchar int vertex_indices', 'end_header', '',
  ].join('\n');
  const bytesOfPoint = kind === 'float' ? 12 : 24;
  const view = new DataView(new ArrayBuffer(nVertices * (bytesOfPoint + 4 * names.length + colours.length) + 13 * nFaces));
  let at = 0;
  const put = (value, size, write) => {
    view[write](at, value, true);
    at += size;
  };
  for (let vertex = 0; vertex < nVertices; vertex++) {
    for (const x of pointOf(level, vertex)) put(x, bytesOfPoint / 3, kind === 'float' ? 'setFloat32' : 'setFloat64');
    for (const channel of [normal, uv]) if (channel) for (const x of valuesAt(channel, vertex)) put(x, 4, 'setFloat32');
    if (colour) for (const x of valuesAt(colour, vertex)) put(Math.round(255 * Math.min(Math.max(x, 0), 1)), 1, 'setUint8');
  }
  for (let i = 0; i < faces.length; i += 3) {
    put(3, 1, 'setUint8');
    for (let k = 0; k < 3; k++) put(faces[i + k], 4, 'setInt32');
  }
  return new Blob([header, view.buffer]);
}

function writeObj(level) {
  const { positions, faces, normal, uv, colour } = level;
  const lines = [];
  const vertices = Array.from({ length: positions.length / 3 }, (_, vertex) => vertex);
  // Further numbers behind a position are a colour to most readers.
  const painted = (vertex) => (colour ? [...valuesAt(colour, vertex)].slice(0, 3) : []);
  for (const vertex of vertices) lines.push(`v ${[...pointOf(level, vertex), ...painted(vertex)].join(' ')}`);
  if (uv) for (const vertex of vertices) lines.push(`vt ${valuesAt(uv, vertex).join(' ')}`);
  if (normal) for (const vertex of vertices) lines.push(`vn ${valuesAt(normal, vertex).join(' ')}`);
  const corner = (v) => [v, uv ? v : '', normal ? v : ''].join('/').replace(/\/+$/, '');
  for (let i = 0; i < faces.length; i += 3) lines.push(`f ${[0, 1, 2].map((k) => corner(faces[i + k] + 1)).join(' ')}`);
  return new Blob([`${lines.join('\n')}\n`]);
}

function writeStl(level) {
  const { faces } = level;
  const view = new DataView(new ArrayBuffer(84 + 50 * (faces.length / 3)));
  view.setUint32(80, faces.length / 3, true);
  for (let face = 0; face < faces.length / 3; face++) {
    const [a, b, c] = [0, 1, 2].map((k) => pointOf(level, faces[3 * face + k]));
    [normalOf(a, b, c), a, b, c].flat().forEach((x, i) => view.setFloat32(84 + 50 * face + 4 * i, x, true));
  }
  return new Blob([view.buffer]);
}

function normalOf(a, b, c) {
  const [u, v] = [b, c].map((other) => other.map((x, axis) => x - a[axis]));
  const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...cross);
  return length > 0 ? cross.map((x) => x / length) : [0, 0, 0];
}

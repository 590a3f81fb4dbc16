// Files for tests: valid ones, from the repository or generated, and invalid ones.

import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

const MESHES = `${import.meta.dirname}/../../../tests/meshes`;

/** Reads a file of tests/meshes as {name, bytes}. */
export function fileOf(path) {
  return { name: path.split('/').pop(), bytes: readFileSync(`${MESHES}/${path}`) };
}

/** Small meshes, one of each format. */
export const TINY = ['obj', 'ply', 'stl', 'off', 'glb'].map((ending) => fileOf(`tiny/tetrahedron.${ending}`));

/** A compressed file. */
export function zipped({ name, bytes }) {
  return { name: `${name}.gz`, bytes: gzipSync(bytes) };
}

/** Files that cannot be read: empty, garbage, cut off. */
export function brokenFiles() {
  const endings = ['obj', 'ply', 'stl', 'off', 'gltf', 'glb', '3mf'];
  const empty = endings.map((ending) => ({ name: `empty.${ending}`, bytes: Buffer.alloc(0) }));
  const noise = Buffer.from(`garbage ${'\u0001\u0002 nothing that a mesh begins with \n'.repeat(40)}`);
  const garbage = endings.map((ending) => ({ name: `garbage.${ending}`, bytes: noise }));
  // OBJ is left out, as a truncated OBJ is valid.
  const whole = TINY.filter(({ name }) => !name.endsWith('obj'));
  const cut = whole.map(({ name, bytes }) => ({ name: `cut-${name}`, bytes: bytes.subarray(0, bytes.length / 3) }));
  const bad = ['bad/truncated_header.ply', 'bad/not_a_mesh.obj', 'bad/zero_bytes.stl', 'bad/single_vertex.ply'].map(fileOf);
  const others = [
    { name: 'cut.obj.gz', bytes: gzipSync(TINY[0].bytes).subarray(0, 30) },
    { name: 'picture.png', bytes: Buffer.from('\x89PNG\r\n', 'latin1') },
    { name: 'words.txt', bytes: Buffer.from('garbage: these are words') },
  ];
  return [...empty, ...garbage, ...cut, ...bad, ...others];
}

/** Returns a wavy sphere with about a given number of faces as a GLB. */
export function waveGlb(nFaces) {
  const n = Math.round(Math.sqrt(nFaces / 2));
  const positions = new Float32Array(3 * n * n);
  const faces = new Uint32Array(6 * n * n);
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      const [u, v] = [i, j].map((k) => (2 * Math.PI * k) / n);
      const radius = 1 + 0.08 * Math.sin(9 * u) * Math.cos(7 * v);
      positions.set([(3 + radius * Math.cos(v)) * Math.cos(u), radius * Math.sin(v), (3 + radius * Math.cos(v)) * Math.sin(u)], 3 * (i * n + j));
      const at = (x, y) => (x % n) * n + (y % n);
      faces.set([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)], 6 * (i * n + j));
    }
  }
  return { name: 'wave.glb', bytes: glb(positions, faces) };
}

function glb(positions, faces) {
  const [nVertices, nCorners] = [positions.length / 3, faces.length];
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    buffers: [{ byteLength: positions.byteLength + faces.byteLength }],
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength }, { buffer: 0, byteOffset: positions.byteLength, byteLength: faces.byteLength }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: nVertices, type: 'VEC3', min: [-5, -5, -5], max: [5, 5, 5] },
      { bufferView: 1, componentType: 5125, count: nCorners, type: 'SCALAR' },
    ],
  };
  const text = Buffer.from(JSON.stringify(json));
  const head = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const body = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(faces.buffer)]);
  const numbers = (...values) => Buffer.from(Uint32Array.from(values).buffer);
  const length = 12 + 8 + head.length + 8 + body.length;
  return Buffer.concat([numbers(0x46546c67, 2, length, head.length, 0x4e4f534a), head, numbers(body.length, 0x004e4942), body]);
}

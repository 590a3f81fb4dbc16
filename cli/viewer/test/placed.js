// Writes a scene for tests of progressions: node placed.js FOLDER
//
// placed.glb has three nodes with one sphere, one of them mirrored, all far from the origin.

import { writeFileSync } from 'node:fs';
import { FORMATS } from '../src/progression/formats.js';

const N = 12;
const ring = (i) => Array.from({ length: 2 * N }, (_, j) => [(Math.PI * i) / N, (Math.PI * j) / N]);
const angles = [[0, 0], ...Array.from({ length: N - 1 }, (_, i) => ring(i + 1)).flat(), [Math.PI, 0]];
const positions = Float32Array.from(angles.flatMap(([t, p]) => [2 * Math.sin(t) * Math.cos(p), Math.sin(t) * Math.sin(p), Math.cos(t)]));
const at = (i, j) => (i === 0 ? 0 : i === N ? angles.length - 1 : 1 + 2 * N * (i - 1) + (j % (2 * N)));
const faces = [];
for (let i = 0; i < N; i++) {
  for (let j = 0; j < 2 * N; j++) {
    if (i < N - 1) faces.push(at(i, j), at(i + 1, j), at(i + 1, j + 1));
    if (i > 0) faces.push(at(i, j), at(i + 1, j + 1), at(i, j + 1));
  }
}
const level = { positions, faces: Uint32Array.from(faces), normal: null, uv: null, colour: null, origin: [0, 0, 0] };
const bytes = Buffer.from(await FORMATS.glb(level).arrayBuffer());
const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
json.nodes = [
  { mesh: 0, translation: [10, 0, 0] }, { mesh: 0, translation: [16, 0, 0], scale: [-1, 1, 1] }, { mesh: 0, translation: [13, 5, 0], rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] },
];
json.scenes[0].nodes = [0, 1, 2];
let text = JSON.stringify(json);
text += ' '.repeat((4 - (text.length % 4)) % 4);
const rest = bytes.subarray(20 + bytes.readUInt32LE(12));
const head = Buffer.from(Uint32Array.of(0x46546c67, 2, 20 + text.length + rest.length, text.length, 0x4e4f534a).buffer);
writeFileSync(`${process.argv[2]}/placed.glb`, Buffer.concat([head, Buffer.from(text), rest]));

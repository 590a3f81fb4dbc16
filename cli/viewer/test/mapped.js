// A mesh with all maps of a material for tests: node mapped.js FOLDER writes mapped.glb, a white ball that is polished metal on its right
// half, glows green around the middle, has bumps above and shallow grooves in shadow below; and flat.glb, the ball with normals of faces.

import { writeFileSync } from 'node:fs';
import { png } from './png.js';

const [N_RINGS, N_AROUND, PIXELS] = [12, 24, 256];

const folder = process.argv[2];
writeFileSync(`${folder}/mapped.glb`, glb(ball(), maps()));
writeFileSync(`${folder}/flat.glb`, glb(flat(ball()), []));

/** Returns a ball of radius 1 as arrays, its seam at the back. */
function ball() {
  const [positions, uvs, faces] = [[], [], []];
  for (let i = 0; i <= N_RINGS; i++) {
    for (let j = 0; j <= N_AROUND; j++) {
      const [down, around] = [(Math.PI * i) / N_RINGS, (2 * Math.PI * j) / N_AROUND];
      positions.push(-Math.sin(down) * Math.sin(around), Math.cos(down), -Math.sin(down) * Math.cos(around));
      uvs.push(j / N_AROUND, i / N_RINGS);
      if (i === N_RINGS || j === N_AROUND) continue;
      const [a, b] = [i * (N_AROUND + 1) + j, (i + 1) * (N_AROUND + 1) + j];
      if (i > 0) faces.push(a, b, a + 1);
      if (i < N_RINGS - 1) faces.push(a + 1, b, b + 1);
    }
  }
  return { positions, normals: positions, uvs, faces };
}

/** Returns the mesh with corners of their own for each face, and the normals of faces. */
function flat({ positions, uvs, faces }) {
  const own = { positions: [], normals: [], uvs: [], faces: faces.map((_, corner) => corner) };
  for (let i = 0; i < faces.length; i += 3) {
    const corners = faces.slice(i, i + 3).map((vertex) => positions.slice(3 * vertex, 3 * vertex + 3));
    const middle = [0, 1, 2].map((axis) => corners.reduce((sum, corner) => sum + corner[axis], 0));
    const length = Math.hypot(...middle);
    for (const corner of corners) {
      own.positions.push(...corner);
      own.normals.push(...middle.map((x) => x / length));
    }
    own.uvs.push(...faces.slice(i, i + 3).flatMap((vertex) => uvs.slice(2 * vertex, 2 * vertex + 2)));
  }
  return own;
}

/** Returns the images: normals, roughness and metal with occlusion, emission. */
function maps() {
  const wave = (x) => Math.sin((32 * Math.PI * x) / PIXELS);
  const byte = (x) => Math.round(127.5 * (x + 1));
  const bumps = png(PIXELS, PIXELS, (x, y) => (y < PIXELS / 2 ? [byte(0.6 * wave(x)), byte(0.6 * wave(y)), 235] : [128, 128, 255]));
  const surface = png(PIXELS, PIXELS, (x, y) => [y > 0.7 * PIXELS && wave(x) > 0 ? 0 : 255, x < PIXELS / 2 ? 255 : 40, x < PIXELS / 2 ? 0 : 255]);
  const glow = png(PIXELS, PIXELS, (x, y) => (Math.abs(y - PIXELS / 2) < 8 ? [0, 255, 0] : [0, 0, 0]));
  return [bumps, surface, glow];
}

function glb({ positions, normals, uvs, faces }, images) {
  const parts = [...[positions, normals, uvs].map((list) => Float32Array.from(list)), Uint32Array.from(faces), ...images].map((part) => {
    const bytes = Buffer.from(part.buffer, part.byteOffset, part.byteLength);
    return Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)]);
  });
  let byteOffset = 0;
  const bufferViews = parts.map((part) => {
    const view = { buffer: 0, byteOffset, byteLength: part.length };
    byteOffset += part.length;
    return view;
  });
  const accessor = (bufferView, count, type, componentType = 5126) => ({ bufferView, componentType, count, type });
  const n = positions.length / 3;
  const materials = images.length === 0 ? undefined : [{
    normalTexture: { index: 0 }, occlusionTexture: { index: 1 }, emissiveTexture: { index: 2 }, emissiveFactor: [1, 1, 1],
    pbrMetallicRoughness: { metallicRoughnessTexture: { index: 1 } },
  }];
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: materials && 0 }] }],
    accessors: [{ ...accessor(0, n, 'VEC3'), min: [-1, -1, -1], max: [1, 1, 1] }, accessor(1, n, 'VEC3'), accessor(2, n, 'VEC2'), accessor(3, faces.length, 'SCALAR', 5125)],
    materials, buffers: [{ byteLength: byteOffset }], bufferViews,
    ...(materials && { textures: images.map((_, source) => ({ source })), images: images.map((_, i) => ({ bufferView: 4 + i, mimeType: 'image/png' })) }),
  };
  const text = Buffer.from(JSON.stringify(json));
  const head = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const numbers = (...values) => Buffer.from(Uint32Array.from(values).buffer);
  return Buffer.concat([numbers(0x46546c67, 2, 28 + head.length + byteOffset, head.length, 0x4e4f534a), head, numbers(byteOffset, 0x004e4942), ...parts]);
}

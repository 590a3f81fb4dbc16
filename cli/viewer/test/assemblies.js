// Writes meshes of several components for tests of progressions: node assemblies.js FOLDER
//
// dust.ply is a bumpy sphere among small ones, of which small levels keep none; sheets.ply has three sheets at one edge, and two
// spheres that share a vertex.

import { writeFileSync } from 'node:fs';

/** Returns a bumpy sphere of n x 2n quads around a centre, as {positions, faces}, closed at both poles. */
function sphere(n, radius, centre, height = 0) {
  const [positions, faces] = [[], []];
  const add = (theta, phi) => {
    const r = radius * (1 + height * Math.sin(6 * theta) * Math.cos(5 * phi));
    const direction = [Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta)];
    positions.push(direction.map((x, axis) => centre[axis] + r * x));
  };
  for (let i = 1; i < n; i++) for (let j = 0; j < 2 * n; j++) add((Math.PI * i) / n, (Math.PI * j) / n);
  const [north, south] = [positions.length, positions.length + 1];
  add(0, 0);
  add(Math.PI, 0);
  const at = (i, j) => 2 * n * (i - 1) + (j % (2 * n));
  for (let j = 0; j < 2 * n; j++) {
    faces.push([north, at(1, j), at(1, j + 1)], [south, at(n - 1, j + 1), at(n - 1, j)]);
    for (let i = 1; i < n - 1; i++) faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
  }
  return { positions, faces };
}

/** Returns a wavy sheet of n x n quads from the z axis in a direction of the plane. */
function sheet(n, angle) {
  const [positions, faces] = [[], []];
  for (let i = 0; i <= n; i++) {
    for (let j = 0; j <= n; j++) {
      const [r, wave] = [i / n, 0.05 * (i / n) * Math.sin((9 * j) / n)];
      positions.push([r * Math.cos(angle) - wave * Math.sin(angle), r * Math.sin(angle) + wave * Math.cos(angle), j / n]);
    }
  }
  const at = (i, j) => (n + 1) * i + j;
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
  }
  return { positions, faces };
}

/** Writes meshes as one file; reading merges vertices at equal positions. */
function write(name, meshes) {
  const lines = [];
  let [first, faces] = [0, []];
  for (const mesh of meshes) {
    lines.push(...mesh.positions.map((p) => p.map((x) => x.toFixed(6)).join(' ')));
    faces = faces.concat(mesh.faces.map((face) => `3 ${face.map((v) => v + first).join(' ')}`));
    first += mesh.positions.length;
  }
  const header = ['ply', 'format ascii 1.0', `element vertex ${first}`, ...['x', 'y', 'z'].map((axis) => `property float ${axis}`),
    `element face ${faces.length}`, 'property list uchar int vertex_indices', 'end_header'];
  writeFileSync(`${process.argv[2]}/${name}.ply`, `${[...header, ...lines, ...faces].join('\n')}\n`);
}

const ring = Array.from({ length: 40 }, (_, i) => [1.5 * Math.cos(0.157 * i), 1.5 * Math.sin(0.157 * i), 0.02 * i]);
write('dust', [sphere(24, 1, [0, 0, 0], 0.15), ...ring.map((centre, i) => sphere(3 + (i % 3), 0.004 + 0.001 * (i % 5), centre))]);
// The poles at which the spheres touch have the same rounded position.
write('sheets', [...[0, 2.1, 4.2].map((angle) => sheet(16, angle)), sphere(12, 0.25, [3, 0, 0.25], 0.1), sphere(12, 0.25, [3, 0, -0.25], 0.1)]);

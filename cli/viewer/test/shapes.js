// Meshes for tests: node shapes.js FOLDER writes knot.obj and wave.obj, closed surfaces with bumps.

import { mkdirSync, writeFileSync } from 'node:fs';

const N = 48;

const folder = process.argv[2];
mkdirSync(folder, { recursive: true });
writeFileSync(`${folder}/knot.obj`, torus((u, v) => 0.5 + 0.12 * Math.sin(5 * u + 3 * v)));
writeFileSync(`${folder}/wave.obj`, torus((u, v) => 0.8 + 0.2 * Math.cos(2 * u) * Math.sin(4 * v)));

/** A ring of radius 2 whose tube has the radius that a function of both angles says. */
function torus(radius) {
  const lines = [];
  for (let i = 0; i < N; i++) {
    for (let j = 0; j < N; j++) {
      const [u, v] = [i, j].map((k) => (2 * Math.PI * k) / N);
      const r = radius(u, v);
      const around = 2 + r * Math.cos(v);
      lines.push(`v ${[around * Math.cos(u), around * Math.sin(u), r * Math.sin(v)].map((x) => x.toFixed(5)).join(' ')}`);
    }
  }
  const vertex = (i, j) => 1 + (i % N) * N + (j % N);
  for (let i = 0; i < N; i++) {
    for (let j = 0; j < N; j++) {
      const [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
      lines.push(`f ${a} ${b} ${c}`, `f ${a} ${c} ${d}`);
    }
  }
  return `${lines.join('\n')}\n`;
}

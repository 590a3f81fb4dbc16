// A textured mesh for tests: node textured.js FOLDER writes plate.obj, a waving plate with a texture whose left half is green and
// whose right half is blue; a strip along its lower edge is of a red material.

import { mkdirSync, writeFileSync } from 'node:fs';
import { png } from './png.js';

const N = 24;
const GREEN = [20, 190, 40];
const BLUE = [30, 60, 220];

const folder = process.argv[2];
mkdirSync(`${folder}/maps`, { recursive: true });
writeFileSync(`${folder}/plate.obj`, plate());
writeFileSync(`${folder}/plate.mtl`, 'newmtl skin\nKd 1 1 1\nmap_Kd maps/skin.png\nnewmtl edge\nKd 0.9 0 0\n');
writeFileSync(`${folder}/maps/skin.png`, png(64, 64, (x) => (x < 32 ? GREEN : BLUE)));

function plate() {
  const lines = ['mtllib plate.mtl'];
  const each = (n, put) => { for (let j = 0; j <= n; j++) for (let i = 0; i <= n; i++) put(i, j); };
  each(N, (i, j) => lines.push(`v ${i} ${j} ${(1.2 * Math.sin(i) * Math.cos(j)).toFixed(4)}`));
  each(N, (i, j) => lines.push(`vt ${i / N} ${j / N}`));
  for (let j = 0; j < N; j++) {
    if (j === 0) lines.push('usemtl edge');
    if (j === 4) lines.push('usemtl skin');
    for (let i = 0; i < N; i++) {
      const [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(([x, y]) => 1 + x + y * (N + 1));
      lines.push(`f ${a}/${a} ${b}/${b} ${c}/${c}`, `f ${a}/${a} ${c}/${c} ${d}/${d}`);
    }
  }
  return `${lines.join('\n')}\n`;
}

// The programs in docs/guide/web.md run, one after the other in one folder, as a reader would run them.

import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

const home = join(import.meta.dirname, '..');
const page = readFileSync(join(home, '../../docs/guide/web.md'), 'utf8');
const folder = mkdtempSync(join(tmpdir(), 'guide-'));

mkdirSync(join(folder, 'node_modules'));
symlinkSync(home, join(folder, 'node_modules/neural-mesh'));
for (const name of ['three', '@gltf-transform']) symlinkSync(join(home, 'node_modules', name), join(folder, 'node_modules', name));
copyFileSync(join(home, '../../tests/meshes/spot.ply'), join(folder, 'spot.ply'));
after(() => rmSync(folder, { recursive: true }));

[...page.matchAll(/^## (.*)\n\n```js\n([^]*?)```/gm)].forEach(([, title, program], i) => {
  test(`${title} in the guide`, () => {
    writeFileSync(join(folder, `${i}.mjs`), program);
    execFileSync(process.execPath, [`${i}.mjs`], { cwd: folder, timeout: 60000, stdio: ['ignore', 'pipe', 'pipe'] });
  });
});

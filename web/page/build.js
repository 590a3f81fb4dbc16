// Builds dist/index.html: one page with style, scripts and WebAssembly inside, which works from a file server or from disk.
//
//   node build.js [PACKAGE] [FOLDER]
//
// PACKAGE is the module to use as `neural-mesh`, ../package/dist/index.js by default. esbuild and three.js are those that
// scripts/viewer installs.

import { createHash } from 'node:crypto';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { bundle, filled, inScript, withParts } from '../../cli/viewer/pages.js';

const here = import.meta.dirname;
const [engine = `${here}/../package/dist/index.js`, folder = `${here}/dist`] = process.argv.slice(2);

const js = await bundle(`${here}/src/main.js`, { alias: { 'neural-mesh': resolve(engine) }, format: 'esm' });
const sheets = await Promise.all([`${here}/../../cli/viewer/src/style.css`, `${here}/src/style.css`].map((file) => bundle(file)));
const css = sheets.join('');

// The policy allows only scripts of the page itself and no requests, so that meshes stay private.
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const rules = [
  "default-src 'none'", `script-src ${hash(inScript(js))} 'wasm-unsafe-eval' blob:`, `style-src ${hash(css)}`, 'worker-src blob:',
  'img-src data: blob:', "base-uri 'none'", "form-action 'none'",
];
const page = withParts(readFileSync(`${here}/src/index.html`, 'utf8')).replace('rules of content', rules.join('; '));

mkdirSync(folder, { recursive: true });
writeFileSync(`${folder}/index.html`, filled(page, { css, js }));
console.log(`${folder}/index.html: ${Math.round(filled(page, { css, js }).length / 1024)} KiB`);

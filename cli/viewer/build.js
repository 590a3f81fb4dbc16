// Makes dist/viewer.html of src: one page with style, script and the licence of three.js inside. `scripts/viewer` runs it.

import { readFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const read = (path) => readFileSync(new URL(path, import.meta.url), 'utf8');
const folder = process.argv[2] ?? 'dist';

const bundle = await build({
  absWorkingDir: import.meta.dirname,
  entryPoints: ['src/main.js'],
  bundle: true,
  minify: true,
  write: false,
  format: 'iife',
  target: ['chrome110', 'firefox113', 'safari16.4'],
  legalComments: 'none',
});
const style = await build({ absWorkingDir: import.meta.dirname, entryPoints: ['src/style.css'], minify: true, write: false });
const licence = read('node_modules/three/LICENSE').trim();

// The replacements are functions because `$` means something in strings.
const page = read('src/page.html')
  .replace('/* style */', () => style.outputFiles[0].text.trim())
  .replace('/* script */', () => bundle.outputFiles[0].text.trim().replaceAll('</script', '<\\/script'))
  .replace('<body>', () => `<body>\n<!--\nThis page contains three.js (threejs.org):\n\n${licence}\n-->`);

mkdirSync(folder, { recursive: true });
writeFileSync(`${folder}/viewer.html`, page);
writeFileSync(`${folder}/LICENSE-three`, `${licence}\n`);
console.log(`${folder}/viewer.html: ${Math.round(page.length / 1024)} KiB`);

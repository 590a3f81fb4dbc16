// Builds dist: the modules of src with the WebAssembly inside as gzipped base64. `node build.js [FOLDER]` reads everything.wasm and
// simplifier.wasm from FOLDER, or from wasm by default.

import { copyFileSync, existsSync, mkdirSync, readFileSync, statSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { gzipSync } from 'node:zlib';
import { build } from 'esbuild';

const here = import.meta.dirname;
const folder = resolve(process.argv[2] ?? join(here, 'wasm'));
const target = ['chrome110', 'firefox114', 'safari16.4', 'node20'];

for (const file of ['everything.wasm', 'simplifier.wasm']) {
  if (existsSync(join(folder, file))) continue;
  console.error(`${join(folder, file)} is missing: scripts/web makes it`);
  process.exit(1);
}

/** Returns the text for the import `packed:NAME`: a WebAssembly module in base64, or the program of the workers. */
async function packedText(name) {
  if (name !== 'worker') return gzipSync(readFileSync(join(folder, `${name}.wasm`)), { level: 9 }).toString('base64');
  const worker = await build({
    entryPoints: [join(here, 'src/worker.js')], bundle: true, minify: true, write: false, format: 'cjs', platform: 'node', target,
  });
  return worker.outputFiles[0].text.trim();
}

const packed = {
  name: 'packed',
  setup(bundler) {
    bundler.onResolve({ filter: /^packed:/ }, ({ path }) => ({ path: path.slice('packed:'.length), namespace: 'packed' }));
    bundler.onLoad({ filter: /./, namespace: 'packed' }, async ({ path }) => ({ contents: await packedText(path), loader: 'text' }));
    // Imports between modules of dist stay imports, so that no code is duplicated.
    bundler.onResolve({ filter: /^\.\/(runtime|simplifier|measure)\.js$/ }, ({ path, kind }) =>
      (kind === 'entry-point' ? undefined : { path, external: true }));
  },
};

mkdirSync(join(here, 'dist'), { recursive: true });
for (const name of ['runtime', 'index', 'simplifier', 'measure', 'gltf-transform', 'three']) {
  const outfile = join(here, 'dist', `${name}.js`);
  // Lines are not joined: Node prints the source line of an error, and the one with the WebAssembly is long.
  await build({
    entryPoints: [join(here, 'src', `${name}.js`)], outfile, bundle: true, format: 'esm', target, packages: 'external', minifyIdentifiers: true, minifySyntax: true,
    plugins: [packed], legalComments: 'none', logLevel: 'warning',
  });
  console.log(`dist/${name}.js: ${Math.round(statSync(outfile).size / 1024)} KiB`);
}
// For bundlers and pages that load WebAssembly by itself.
copyFileSync(join(folder, 'simplifier.wasm'), join(here, 'dist', 'simplifier.wasm'));
for (const licence of ['LICENSE-APACHE', 'LICENSE-MIT']) copyFileSync(join(here, '../..', licence), join(here, 'dist', licence));

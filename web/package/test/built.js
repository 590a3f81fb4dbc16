// Imports a module of dist for tests, or fails with one line if it is not built.

import { existsSync } from 'node:fs';

/** Imports `dist/NAME.js`. */
export async function built(name) {
  const url = new URL(`../dist/${name}.js`, import.meta.url);
  if (!existsSync(url)) throw new Error(`dist/${name}.js is missing: run scripts/web, or node build.js FOLDER_OF_WASM`);
  return import(url);
}

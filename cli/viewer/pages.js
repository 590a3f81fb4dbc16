// Builds self-contained pages: inserts shared HTML, and bundles scripts, styles and the licence of three.js.

import { readFileSync } from 'node:fs';
import { build } from 'esbuild';

const read = (path) => readFileSync(new URL(path, import.meta.url), 'utf8');

/** The licence of three.js, which every page contains. */
export const licence = read('node_modules/three/LICENSE').trim();

/** Bundles a script or style sheet with its imports; `alias` maps names of packages to files. */
export async function bundle(file, { alias = {}, format = 'iife' } = {}) {
  const { outputFiles } = await build({
    entryPoints: [file],
    bundle: true,
    minify: true,
    write: false,
    format,
    alias,
    target: ['chrome110', 'firefox113', 'safari16.4'],
    legalComments: 'none',
    loader: { '.webp': 'dataurl' },
  });
  return outputFiles[0].text.trim();
}

/** Returns a page with shared HTML files inserted, indented as their placeholders. */
export function withParts(page) {
  return page.replace(/^( *)<!-- (\w+\.html) -->\n/gm, (_, blanks, part) => read(`src/${part}`).replace(/^(?=.)/gm, blanks));
}

/** Returns a page with its style, its script and the licence inside. */
export function filled(page, { css, js }) {
  // The replacements are functions, as `$` has a meaning in replacement strings.
  return page
    .replace('/* style */', () => css)
    .replace('/* script */', () => inScript(js))
    .replace(/<body.*>/, (body) => `${body}\n<!--\nThis page contains three.js (threejs.org):\n\n${licence}\n-->`);
}

/** Escapes a script for a script element. */
export function inScript(js) {
  return js.replaceAll('</script', '<\\/script');
}

// Makes pages that carry everything inside: parts of HTML put in place, scripts and styles bundled, the licence of three.js beside them.

import { readFileSync } from 'node:fs';
import { build } from 'esbuild';

const read = (path) => readFileSync(new URL(path, import.meta.url), 'utf8');

/** The licence of three.js, which every page contains. */
export const licence = read('node_modules/three/LICENSE').trim();

/** Bundles a script or style sheet with all that it imports; `alias` says which file stands for the name of a package. */
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
  });
  return outputFiles[0].text.trim();
}

/** A page with the parts that others have as well, at the depth where they are named. */
export function withParts(page) {
  return page.replace(/^( *)<!-- (\w+\.html) -->\n/gm, (_, blanks, part) => read(`src/${part}`).replace(/^(?=.)/gm, blanks));
}

/** A page with its style, its script and the licence inside. */
export function filled(page, { css, js }) {
  // The replacements are functions because `$` means something in strings.
  return page
    .replace('/* style */', () => css)
    .replace('/* script */', () => inScript(js))
    .replace(/<body.*>/, (body) => `${body}\n<!--\nThis page contains three.js (threejs.org):\n\n${licence}\n-->`);
}

/** A script as it can stand in an element. */
export function inScript(js) {
  return js.replaceAll('</script', '<\\/script');
}

// Builds dist/pages.gz from src: viewer.html, clusters.html and progression.html with style, script and the
// licence of three.js inside, and dist/LICENSE-three. With `--check` it compares them with those that are there. `scripts/viewer` runs it.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { readPages, writePages } from './packed.js';
import { bundle, filled, licence, withParts } from './pages.js';

const source = (file) => `${import.meta.dirname}/src/${file}`;
const [PAGES, LICENCE] = ['dist/pages.gz', 'dist/LICENSE-three'];

/** Makes a page from one entry point and style sheets. */
async function make(page, script, styles) {
  const [js, ...css] = await Promise.all([script, ...styles].map((file) => bundle(source(file))));
  return filled(withParts(readFileSync(source(page), 'utf8')), { css: css.join(''), js });
}

const pages = {
  'viewer.html': await make('page.html', 'main.js', ['style.css']),
  'clusters.html': await make('clusters.html', 'clusters/main.js', ['style.css', 'single.css', 'clusters.css']),
  'progression.html': await make('progression.html', 'progression/main.js', ['style.css', 'single.css', 'progression.css']),
};
if (process.argv[2] === '--check') {
  // Other versions of zlib compress to other bytes, so what they decompress to is compared.
  const there = readPages(PAGES);
  const names = [...new Set([...Object.keys(pages), ...Object.keys(there)])].filter((name) => pages[name] !== there[name]);
  if (readFileSync(LICENCE, 'utf8') !== `${licence}\n`) names.push('LICENSE-three');
  if (names.length > 0) {
    console.error(`cli/viewer/dist: ${names.join(', ')} out of step: run scripts/viewer`);
    process.exit(1);
  }
  console.log('cli/viewer/dist is in step with its sources');
} else {
  mkdirSync('dist', { recursive: true });
  writePages(PAGES, pages);
  writeFileSync(LICENCE, `${licence}\n`);
  Object.entries(pages).forEach(([name, text]) => console.log(`${name}: ${Math.round(text.length / 1024)} KiB`));
}

// Builds dist/viewer.html, dist/clusters.html and dist/progression.html from src: pages with style, script and the licence of three.js
// inside. `scripts/viewer` runs it.

import { readFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { bundle, filled, licence, withParts } from './pages.js';

const source = (file) => `${import.meta.dirname}/src/${file}`;
const folder = process.argv[2] ?? 'dist';

/** Writes a page from one entry point and style sheets. */
async function make(page, script, styles) {
  const [js, ...css] = await Promise.all([script, ...styles].map((file) => bundle(source(file))));
  const text = filled(withParts(readFileSync(source(page), 'utf8')), { css: css.join(''), js });
  const name = `${folder}/${page === 'page.html' ? 'viewer.html' : page}`;
  writeFileSync(name, text);
  console.log(`${name}: ${Math.round(text.length / 1024)} KiB`);
}

mkdirSync(folder, { recursive: true });
await make('page.html', 'main.js', ['style.css']);
await make('clusters.html', 'clusters/main.js', ['style.css', 'single.css', 'clusters.css']);
await make('progression.html', 'progression/main.js', ['style.css', 'single.css', 'progression.css']);
writeFileSync(`${folder}/LICENSE-three`, `${licence}\n`);

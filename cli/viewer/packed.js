// Packs the built pages into one file, which git, the published crate and the program hold in place of 1.8 MB of text.

import { readFileSync, writeFileSync } from 'node:fs';
import { gunzipSync, gzipSync } from 'node:zlib';

/** Writes the pages, an object of name and text, as compressed JSON; `cli/src/page/empty_pages.rs` reads it. */
export function writePages(path, pages) {
  writeFileSync(path, gzipSync(JSON.stringify(pages), { level: 9 }));
}

/** Returns the pages in the file, an object of name and text. */
export function readPages(path) {
  return JSON.parse(gunzipSync(readFileSync(path)));
}

/** Writes the built page of that name, which holds no data, into the folder; returns its path. */
export function writeEmptyPage(name, folder) {
  const path = `${folder}/empty-${name}`;
  writeFileSync(path, readPages(`${import.meta.dirname}/dist/pages.gz`)[name]);
  return path;
}

// open_files FILE...: opens OBJ, PLY, STL, glTF and GLB files with the loaders of three.js, draws them, and prints for each a
// line of JSON: the number of triangles in a list, or the errors. `scripts/reopened` runs it.

import { existsSync, readFileSync } from 'node:fs';
import { basename, dirname, extname, join } from 'node:path';
import { build } from 'esbuild';
import { launch } from './browser.js';

const ORIGIN = 'http://files.test/';
const bundle = await build({
  absWorkingDir: import.meta.dirname, entryPoints: ['file_opener.js'], bundle: true, write: false, format: 'iife',
});

/** Opens a file in a new page, which can only load files of its folder. */
async function openFile(browser, path) {
  const complaints = [];
  const page = await browser.newPage();
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', (error) => complaints.push(String(error)));
  await page.route('**/*', (route) => {
    const { pathname } = new URL(route.request().url());
    if (pathname === '/') return route.fulfill({ contentType: 'text/html', body: '<link rel="icon" href="data:,"><body></body>' });
    const file = join(dirname(path), decodeURIComponent(pathname));
    return existsSync(file) ? route.fulfill({ body: readFileSync(file) }) : route.fulfill({ status: 404 });
  });
  await page.goto(ORIGIN);
  await page.addScriptTag({ content: bundle.outputFiles[0].text });
  const where = [ORIGIN + encodeURIComponent(basename(path)), extname(path).toLowerCase()];
  const { n_triangles, n_drawn } = await page.evaluate(([url, kind]) => openFile(url, kind), where);
  if (n_drawn === 0) complaints.push('nothing was drawn');
  await page.close();
  return complaints.length > 0 ? complaints.join('; ') : [n_triangles];
}

const browser = await launch();
for (const path of process.argv.slice(2)) {
  const found = await openFile(browser, path).catch((error) => String(error).split('\n')[0]);
  console.log(JSON.stringify(found));
}
await browser.close();

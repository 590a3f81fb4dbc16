// Tests the package in a page and in a page's worker in Chromium: `CHROMIUM=chromium node --test test/page.test.js`.

import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { build } from 'esbuild';
import { chromium } from 'playwright-core';

// An empty name selects Playwright's own browser.
const name = process.env.CHROMIUM ?? 'none';
const skip = name === 'none' ? 'CHROMIUM names no browser' : false;
const inPath = () => process.env.PATH.split(delimiter).map((folder) => join(folder, name)).find(existsSync);
const executablePath = name === '' ? undefined : (!name.includes('/') && inPath()) || name;
const dist = new URL('../dist/', import.meta.url);
const shapes = readFileSync(new URL('shapes.js', import.meta.url));
/** Page of the guide, with the package's address on this server. */
const guide = readFileSync(new URL('../../../docs/guide/web.md', import.meta.url), 'utf8')
  .match(/```html\n([^]*?)```/)[1].replace('./node_modules/neural-mesh/dist/', '/');
/** Program of a worker that uses the package. */
const NESTED = `import { simplify } from './index.js';
  import { torus } from './shapes.js';
  postMessage((await simplify(torus(), { faces: 500 })).results[0].faces.length);`;
let server = null;
let browser = null;

/** Serves dist; below /strict/ with a policy that forbids workers from Blobs, below /allowed/ with one that allows them. */
function serve(request, response) {
  const [, policy, path] = request.url.match(/^\/(?:(strict|allowed)\/)?(.*)$/);
  const workers = policy === 'allowed' ? 'blob:' : "'self'";
  if (policy) response.setHeader('Content-Security-Policy', `default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src ${workers}`);
  if (path === 'favicon.ico') return response.writeHead(404).end();
  if (path === 'guide') return response.setHeader('Content-Type', 'text/html').end(guide);
  if (path === '') return response.setHeader('Content-Type', 'text/html').end('<!doctype html><title>page</title>');
  response.setHeader('Content-Type', 'text/javascript');
  if (path === 'shapes.js') return response.end(shapes);
  if (path === 'nested.js') return response.end(NESTED);
  return response.end(readFileSync(new URL(path, dist)));
}

before(async () => {
  if (skip) return;
  server = createServer(serve).listen(0);
  browser = await chromium.launch({ executablePath, args: ['--no-sandbox'] });
});

after(async () => {
  await browser?.close();
  server?.close();
});

async function open(path) {
  const page = await browser.newPage();
  await page.goto(`http://localhost:${server.address().port}${path}`);
  return page;
}

test('a page stays alive while a worker runs, and ends it', { skip }, async () => {
  const page = await open('/');
  const { nFaces, frames, shares, name, ms } = await page.evaluate(async () => {
    const { simplify } = await import('/index.js');
    const { torus } = await import('/shapes.js');
    let [frames, shares] = [0, 0];
    const timer = setInterval(() => frames++, 5);
    const { results } = await simplify(torus(400, 200), { ratio: 0.1 }, { progress: () => shares++ });
    clearInterval(timer);
    const abort = new AbortController();
    const run = simplify(torus(400, 200), { ratio: 0.1 }, { signal: abort.signal }).catch((error) => error.name);
    await new Promise((resolve) => setTimeout(resolve, 100));
    const from = performance.now();
    abort.abort();
    return { nFaces: results[0].faces.length / 3, frames, shares, name: await run, ms: performance.now() - from };
  });
  assert.ok(nFaces > 0 && frames > 10 && shares > 2, `${nFaces} ${frames} ${shares}`);
  assert.equal(name, 'AbortError');
  assert.ok(ms < 50, `${ms} ms`);
});

test('a file of a page keeps its name', { skip }, async () => {
  const page = await open('/');
  const name = await page.evaluate(async () => {
    const { simplify } = await import('/index.js');
    const { torus, toObj } = await import('/shapes.js');
    return (await simplify(new File([toObj(torus())], 'torus.obj'), { ratio: 0.1 })).files[0].name;
  });
  assert.equal(name, 'torus.obj');
});

test('the page of the guide gives a lighter file', { skip }, async () => {
  const page = await open('/guide');
  await page.setInputFiles('#file', fileURLToPath(new URL('../../../tests/meshes/spot.ply', import.meta.url)));
  const save = page.locator('#save[href]');
  await save.waitFor();
  assert.equal(await save.textContent(), 'spot.ply');
});

test('the package runs in a worker of a page', { skip }, async () => {
  const page = await open('/');
  const length = await page.evaluate(() => new Promise((resolve, reject) => {
    const worker = new Worker('/nested.js', { type: 'module' });
    worker.onmessage = ({ data }) => resolve(data);
    worker.onerror = (event) => reject(new Error(event.message));
  }));
  assert.ok(length > 0 && length <= 1500, `${length}`);
});

test('where the policy allows no workers of Blobs, calls run in the page', { skip }, async () => {
  for (const [policy, isAlive] of [['strict', false], ['allowed', true]]) {
    const page = await open(`/${policy}/`);
    const { length, frames } = await page.evaluate(async (from) => {
      const { simplify } = await import(`/${from}/index.js`);
      const { torus } = await import(`/${from}/shapes.js`);
      await simplify(torus(), { faces: 500 });
      let frames = 0;
      const timer = setInterval(() => frames++, 5);
      const { results } = await simplify(torus(300, 150), { faces: 500 });
      clearInterval(timer);
      return { length: results[0].faces.length, frames };
    }, policy);
    assert.ok(length > 0 && length <= 1500, `${length}`);
    assert.equal(frames > 20, isAlive, `${policy}: ${frames}`);
  }
});

test('a page from the disk stays alive, too', { skip }, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'page-'));
  try {
    const contents = "export { simplify } from './dist/index.js'; export { torus } from './test/shapes.js';";
    const stdin = { contents, resolveDir: fileURLToPath(new URL('..', import.meta.url)) };
    await build({ stdin, bundle: true, format: 'iife', globalName: 'bundle', outfile: join(folder, 'bundle.js'), logLevel: 'error' });
    writeFileSync(join(folder, 'page.html'), '<!doctype html><script src="bundle.js"></script>');
    const page = await browser.newPage();
    await page.goto(pathToFileURL(join(folder, 'page.html')).href);
    const frames = await page.evaluate(async () => {
      const { simplify, torus } = globalThis.bundle;
      await simplify(torus(), { faces: 500 });
      let frames = 0;
      const timer = setInterval(() => frames++, 5);
      await simplify(torus(300, 150), { faces: 500 });
      clearInterval(timer);
      return frames;
    });
    assert.ok(frames > 20, `${frames}`);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('NeuralSimplifier runs in a page', { skip }, async () => {
  const page = await open('/');
  const length = await page.evaluate(async () => {
    const { NeuralSimplifier } = await import('/simplifier.js');
    const { torus } = await import('/shapes.js');
    await NeuralSimplifier.ready;
    const { positions, faces } = torus();
    return NeuralSimplifier.simplify(faces, positions, 3, 1500, 1)[0].length;
  });
  assert.ok(length > 0 && length <= 1500, `${length}`);
});

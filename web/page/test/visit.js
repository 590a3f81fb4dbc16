// Opens the page in a headless Chromium, from a file server or from disk, and asserts that it makes no errors and no requests.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

/** Path of the page to test: PAGE, or the output of build.js. */
export const PAGE = resolve(process.env.PAGE ?? `${import.meta.dirname}/../dist/index.html`);

/** Timeout of every step in milliseconds, generous for software rendering. */
const PATIENCE = 120_000;

/** Serves only the page. */
export async function serve() {
  const server = createServer(async (request, response) => {
    if (request.url !== '/') return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': 'text/html' });
    return response.end(await readFile(PAGE));
  });
  await new Promise((listening) => server.listen(0, '127.0.0.1', listening));
  return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** Address of the page on disk. */
export const onDisk = pathToFileURL(PAGE).href;

/** Opens the page; `complaints` collects errors of the console and requests. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1200, height: 800 }, acceptDownloads: true, permissions: ['clipboard-read', 'clipboard-write'], ...options,
  });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const complaints = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !isOfDriver(message)) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(String(error)));
  context.on('request', (request) => {
    if (request.url() !== url && !request.url().startsWith('blob:')) complaints.push(`request for ${request.url()}`);
  });
  await page.goto(url);
  await page.waitForSelector('html[data-state="ready"]');
  await page.waitForSelector('#downloads button', { state: 'attached' });
  return { page, complaints };
}

/** Messages of software rendering that are ignored. */
function isOfDriver(message) {
  return /GL Driver Message|GPU stall/.test(message.text());
}

/** Opens the page, uses it, and asserts that there were no errors. */
export async function visit(browser, url, options, use) {
  const { page, complaints } = await open(browser, url, options);
  try {
    await use(page);
    assert.deepEqual(complaints, []);
  } finally {
    await page.context().close();
  }
}

/** Drops files {name, bytes} on the page. */
export async function drop(page, files) {
  const packed = files.map(({ name, bytes }) => ({ name, base64: Buffer.from(bytes).toString('base64') }));
  await page.evaluate((given) => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of given) {
      transfer.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], name));
    }
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, packed);
}

/** Drags a folder from disk onto the page. */
export async function dragFolder(page, path) {
  const session = await page.context().newCDPSession(page);
  const data = { items: [], files: [path], dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop']) await session.send('Input.dispatchDragEvent', { type, x: 300, y: 300, data });
}

/** Moves a finger from one place to another. */
export async function swipe(page, from, to) {
  const session = await page.context().newCDPSession(page);
  const touch = (type, points) => session.send('Input.dispatchTouchEvent', { type, touchPoints: points });
  await touch('touchStart', [from]);
  for (const share of [0.3, 0.6, 1]) {
    await touch('touchMove', [{ x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) }]);
  }
  await touch('touchEnd', []);
}

/** Waits until the result of this title is shown. */
export async function isShown(page, title) {
  await page.waitForSelector(`html[data-shown="${title}"]`);
}

/** Waits until no job runs. */
export async function isIdle(page) {
  await page.waitForSelector('#work.idle', { state: 'attached' });
}

/** Names of the examples. */
export const EXAMPLE_NAMES = ['Knot', 'Gear', 'Planet'];

/** Button of the first example. */
export const EXAMPLE = '[data-example="Knot"]';

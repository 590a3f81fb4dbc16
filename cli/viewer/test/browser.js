// Starts a headless Chromium without a graphics card, for tests, measurements and pictures of the page.

import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright';

/** Timeout of every step, in milliseconds. */
const PATIENCE = 180_000;

/** Starts the browser that CHROMIUM names, or Playwright's own. */
export function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM || undefined,
    args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
  });
}

/** Opens a page of the program and waits until it has drawn. `complaints` collects errors and requests. */
export async function open(browser, path, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 700 }, ...options });
  // Software rendering is slow on a busy machine.
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const complaints = [];
  const url = pathToFileURL(path).href;
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', (error) => complaints.push(String(error)));
  await context.route('**/*', (route) => {
    if (route.request().url() === url) return route.continue();
    complaints.push(`request for ${route.request().url()}`);
    return route.abort();
  });
  await page.goto(url);
  await page.waitForSelector('html[data-state="ready"]');
  return { page, complaints };
}

/** Opens a page, uses it, and asserts that there were no errors or requests. */
export async function visit(browser, path, options, use) {
  const { page, complaints } = await open(browser, path, options);
  await use(page);
  assert.deepEqual(complaints, []);
  await page.context().close();
}

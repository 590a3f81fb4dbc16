// The page of `neural-mesh-bench evaluate` in a browser: tables sort, choices change what is shown, worst cases open, large pages open soon.
//
// `scripts/viewer_test` makes PAGES/run, an evaluation of three methods on two meshes, and the large pages.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { inflateRawSync } from 'node:zlib';
import { unpackValues } from '../src/points.js';
import { launch, visit } from './browser.js';
import { opening } from './load_time.js';
import { makeEye, shoot } from './pixels.js';

const RUN = `${process.env.PAGES}/run`;
const REPORT = `${RUN}/report.html`;

let browser;
let eye;

before(async () => {
  browser = await launch();
  eye = await makeEye(browser);
});
after(() => browser.close());

const withPage = (options, use) => visit(browser, REPORT, options, use);

/** The numbers of a column of a table, by its title; empty cells as null. */
function column(page, table, title) {
  return page.evaluate(([id, title]) => {
    const { tHead, tBodies } = document.getElementById(id);
    const at = [...tHead.rows[0].cells].findIndex((cell) => cell.textContent.startsWith(title));
    return [...tBodies[0].rows].map(({ cells }) => (cells[at].textContent === '' ? null : Number(cells[at].textContent.replaceAll(',', ''))));
  }, [table, title]);
}

async function changes(page, selector, act, least) {
  const shot = await shoot(page, selector);
  await act();
  await page.waitForSelector('html[data-plots="ready"]');
  const share = await eye.differing(shot, await shoot(page, selector));
  assert.ok(share >= least, `${share} of the pixels changed`);
}

test('a table sorts by any column, both ways', () => withPage({}, async (page) => {
  const isSorted = (values, sign) => values.every((value, i) => i === 0 || sign * (value - values[i - 1]) >= 0);
  for (const title of ['seconds', 'distance max', 'faces']) {
    const head = page.locator('#all thead th', { has: page.getByRole('button', { name: title }) }).first();
    await head.getByRole('button').click();
    assert.equal(await head.getAttribute('aria-sort'), 'ascending');
    const values = await column(page, 'all', title);
    assert.ok(values.length === 3 && isSorted(values, 1), `${title}: ${values}`);
    await head.getByRole('button').click();
    assert.ok(isSorted(await column(page, 'all', title), -1));
    assert.equal(await head.getAttribute('aria-sort'), 'descending');
  }
}));

test('figure, ratio and statistic change tables and plots', () => withPage({}, async (page) => {
  assert.equal(await page.textContent('#title-one'), 'distance mean');
  const at = async () => JSON.stringify(await column(page, 'all', 'distance mean'));
  const seen = [await at()];
  await changes(page, '.plots', () => page.selectOption('#ratio', '1'), 0.002);
  seen.push(await at());
  for (const statistic of ['mean', 'quotient to qem']) {
    await page.getByRole('radio', { name: statistic, exact: true }).check();
    assert.equal(await page.textContent('#title-all'), `All figures at ratio 0.3: ${statistic}`);
  }
  seen.push(await at());
  assert.equal(new Set(seen).size, seen.length, `${seen}`);
  assert.ok((await column(page, 'all', 'distance mean')).includes(1), 'qem over qem is 1');
  await changes(page, '.plots', () => page.selectOption('#figure', { label: 'normal angle' }), 0.002);
  assert.equal(await page.textContent('#title-one'), 'normal angle');
  await changes(page, '.plots', () => page.click('#legend button'), 0.001);
}));

test('the values are those of the rows', async () => {
  const page = readFileSync(REPORT, 'utf8');
  const { overview, meshes } = JSON.parse(page.match(/id="evaluation">(.*?)<\/script>/)[1]);
  const rows = JSON.parse(readFileSync(`${RUN}/rows.json`, 'utf8'));
  const [text] = page.match(new RegExp(`(?<=data-of="points-${overview.columns.findIndex(({ name }) => name === 'distance_mean')}">)[^<]*`));
  const values = await unpackValues({ bytes: inflateRawSync(Buffer.from(text, 'base64')), at: 0 }, rows.length);
  for (const { mesh, ratio, method, distance_mean: wanted } of rows) {
    const [m, r, k] = [overview.methods.indexOf(method), overview.ratios.indexOf(ratio), meshes.findIndex(([name]) => name === mesh)];
    const found = values[(r * overview.methods.length + m) * meshes.length + k];
    assert.ok(Math.abs(found - wanted) < wanted / 1000, `${found} is not ${wanted}`);
  }
});

test('a point says whose it is', () => withPage({}, async (page) => {
  const plot = page.locator('.plot').first();
  await plot.scrollIntoViewIfNeeded();
  const box = await plot.boundingBox();
  const names = new Set();
  for (let x = 60; x < box.width; x += 6) {
    for (let y = 20; y < box.height - 40; y += 14) {
      await page.mouse.move(box.x + x, box.y + y);
      const tip = plot.locator('.tip');
      if (await tip.isVisible()) names.add((await tip.innerText()).split('\n')[1]);
    }
    if (names.size >= 3) break;
  }
  assert.ok([...names].some((name) => /^(knot|wave)\.obj at ratio 0\.1$/.test(name)), [...names].join('; '));
}));

test('worst cases open in 3-D', () => withPage({}, async (page) => {
  for (const pane of ['#pane-0', '#pane-1']) {
    const covered = await eye.covered(await shoot(page, pane));
    assert.ok(covered > 0.1 && covered < 0.95, `${covered} of ${pane} is covered`);
  }
  const cases = page.locator('#worst .open');
  assert.equal(await cases.count(), 3 * 3);
  const other = await cases.evaluateAll((buttons) => buttons.findIndex(({ textContent }) => textContent !== buttons[0].textContent));
  await changes(page, '.stage', async () => {
    await cases.nth(other).click();
    await page.waitForFunction((name) => document.querySelector('#pane-0 .name').textContent === name, await cases.nth(other).textContent());
    await page.waitForFunction(() => document.getElementById('wait').hidden);
  }, 0.05);
  assert.equal(await cases.nth(other).getAttribute('aria-pressed'), 'true');
  await changes(page, '.stage', () => page.keyboard.press('c'), 0.05);
}));

test('light and dark, and every control has a name', () => withPage({ colorScheme: 'dark' }, async (page) => {
  assert.equal(await page.getAttribute('html', 'data-theme'), 'dark');
  await changes(page, '.plots', () => page.selectOption('#theme', 'light'), 0.3);
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select')]
    .filter((element) => !(element.ariaLabel || element.labels?.length || element.textContent.trim())).map((element) => element.outerHTML));
  assert.deepEqual(nameless, []);
}));

test('a phone has room for all of it', () => withPage({ viewport: { width: 390, height: 844 }, hasTouch: true }, async (page) => {
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
}));

for (const name of ['large-report', 'large-compare']) {
  test(`${name} opens within three seconds`, async (context) => {
    const { size, drawn, total } = await opening(browser, `${process.env.PAGES}/${name}.html`);
    context.diagnostic(`${size.toFixed(1)} MB, drawn after ${drawn} ms, ${total} ms of the page's own thread`);
    // Time of the processor holds on a busy machine as well.
    assert.ok(size > 25 && total < 3000, `${size} MB, ${total} ms`);
  });
}

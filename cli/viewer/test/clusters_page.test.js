// The page of `neural-mesh clusters` in a browser: it draws, the cut follows its settings without cracks, and files can be opened.
//
// `scripts/viewer_test` makes clusters.html and spot.nmc in PAGES, both of the same closed mesh, dust.nmc, and plate-clusters.html, which
// has a texture.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { writeEmptyPage } from '../packed.js';
import { launch, visit } from './browser.js';
import { NMC, oddEdges } from './hierarchy.js';
import { makeEye, shoot } from './pixels.js';

const PAGE = `${process.env.PAGES}/clusters.html`;
const EMPTY = writeEmptyPage('clusters.html', process.env.PAGES);

let browser;
let eye;

before(async () => {
  browser = await launch();
  eye = await makeEye(browser);
});
after(() => browser.close());

/** Opens a page with a hierarchy, and waits until its cut is complete. */
const withHierarchy = (options, use) => visit(browser, PAGE, options, async (page) => {
  await isSettled(page);
  await use(page);
});

/** Waits until a cut is complete, and returns its triangles. */
async function isSettled(page) {
  await page.waitForFunction(() => Number(document.documentElement.dataset.cut) > 0);
  await shoot(page, '.stage');
  return Number(await page.getAttribute('html', 'data-cut'));
}

async function setError(page, log2) {
  await page.evaluate((value) => {
    const slider = document.getElementById('pixels');
    slider.value = value;
    slider.dispatchEvent(new Event('input'));
  }, log2);
  await shoot(page, '.stage');
  return isSettled(page);
}

const trianglesIn = (page) => page.evaluate(() => [...document.getElementById('canvas').drawnTriangles()]);

async function changedBy(page, act) {
  const shot = await shoot(page, '.stage');
  await act();
  return eye.differing(shot, await shoot(page, '.stage'));
}

test('the mesh is drawn, and its figures are shown', () => withHierarchy({}, async (page) => {
  const covered = await eye.covered(await shoot(page, '#pane-0'));
  assert.ok(covered > 0.1 && covered < 0.9, `${covered} is covered`);
  assert.equal(await page.textContent('#name'), 'spot.ply');
  await page.waitForFunction(() => /\d/.test(document.getElementById('figure-drawn').textContent));
  assert.match(await page.textContent('#figure-pages'), /^\d+ of \d+$/);
}));

test('triangles fall as the error grows, and no cut has a crack', () => withHierarchy({}, async (page) => {
  const counts = [];
  for (const log2 of [-4, 0, 2, 4, 6, 9]) {
    counts.push(await setError(page, log2));
    const triangles = await trianglesIn(page);
    assert.equal(triangles.length / 9, counts.at(-1));
    assert.equal(oddEdges(triangles), 0, `2^${log2} pixels`);
  }
  assert.equal(counts[0], 5856);
  assert.ok(counts.every((n, i) => i === 0 || n <= counts[i - 1]) && counts.at(-1) < 300, `${counts}`);
}));

test('the cut follows the camera unless it is frozen', () => withHierarchy({}, async (page) => {
  await page.focus('#canvas');
  const near = await isSettled(page);
  const moveAway = async () => {
    for (let i = 0; i < 12; i++) await page.keyboard.press('-');
    await shoot(page, '.stage');
    return isSettled(page);
  };
  await page.keyboard.press('f');
  assert.equal(await moveAway(), near);
  await page.keyboard.press('f');
  await shoot(page, '.stage');
  assert.ok(await isSettled(page) < near);
}));

test('the first view frames all of the finest level, with components that coarser ones lack', async () => {
  for (const viewport of [{ width: 1000, height: 700 }, { width: 390, height: 844 }]) {
    await visit(browser, EMPTY, { viewport }, async (page) => {
      await page.setInputFiles('#file', { name: 'dust.nmc', mimeType: '', buffer: readFileSync(`${process.env.PAGES}/dust.nmc`) });
      await isSettled(page);
      await setError(page, -4);
      assert.equal(await eye.atBorder(await shoot(page, '.stage')), 0);
      await page.waitForFunction(() => document.getElementById('figure-cut').textContent === '4,208');
      assert.equal(await page.textContent('#figure-drawn'), '4,208');
    });
  }
});

test('clusters outside of the view are part of the cut and not drawn', () => withHierarchy({}, async (page) => {
  await setError(page, -4);
  await page.focus('#canvas');
  for (let i = 0; i < 18; i++) await page.keyboard.press('+');
  await isSettled(page);
  await page.waitForFunction(() => document.getElementById('figure-drawn').textContent !== '5,856');
  const [drawn, cut] = await Promise.all(['drawn', 'cut'].map(async (id) => Number((await page.textContent(`#figure-${id}`)).replace(',', ''))));
  assert.equal(cut, 5856);
  assert.ok(drawn > 0 && drawn < cut / 2, `${drawn}`);
  assert.ok(await eye.covered(await shoot(page, '#pane-0')) > 0.9 || drawn > 100);
}));

test('the wheel zooms to the cursor', () => withHierarchy({}, async (page) => {
  const { x, y } = await page.locator('#pane-0').boundingBox();
  await page.mouse.move(x + 12, y + 12);
  for (let i = 0; i < 12; i++) await page.mouse.wheel(0, -300);
  await page.waitForTimeout(300);
  assert.ok(await eye.covered(await shoot(page, '#pane-0')) < 0.05);
}));

test('a flight shows coarser levels and ends where it began', () => withHierarchy({}, async (page) => {
  const first = await isSettled(page);
  const shot = await shoot(page, '#pane-0');
  await page.keyboard.press('v');
  await page.waitForSelector('#fly[aria-pressed="true"]');
  await page.waitForFunction((most) => Number(document.documentElement.dataset.cut || Infinity) < most, first / 3);
  await page.waitForSelector('#fly[aria-pressed="false"]');
  assert.equal(await isSettled(page), first);
  assert.ok(await eye.differing(shot, await shoot(page, '#pane-0')) < 0.01);
}));

test('textures of the input are shown by choice', async () => {
  await visit(browser, `${process.env.PAGES}/plate-clusters.html`, {}, async (page) => {
    await isSettled(page);
    await page.keyboard.press('x');
    const shot = await shoot(page, '#pane-0');
    const [red, green, blue] = await Promise.all([0, 1, 2].map((channel) => eye.mostly(shot, channel)));
    assert.ok(green.left > 0.1 && green.left > 2 * green.right, JSON.stringify(green));
    assert.ok(blue.right > 0.1 && blue.right > 2 * blue.left, JSON.stringify(blue));
    assert.ok(red.lower > 0.01 && red.lower > 2 * red.upper, JSON.stringify(red));
  });
  await withHierarchy({}, async (page) => assert.ok(await page.isHidden('#texture')));
});

test('every colouring and switch changes the picture', () => withHierarchy({}, async (page) => {
  for (const key of ['l', 's', 't', 'c']) {
    assert.ok(await changedBy(page, () => page.keyboard.press(key)) > 0.03, key);
    await page.waitForSelector(`[data-key="${key}"]:checked`);
  }
  assert.ok(await changedBy(page, () => page.keyboard.press('z')) > 0.03);
  await page.keyboard.press('a');
  await page.waitForFunction(() => Number(document.getElementById('figure-frames').textContent) > 0);
  await page.keyboard.press('a');
  await page.waitForFunction(() => document.getElementById('figure-frames').textContent === 'at rest');
}));

test('keys change the error', () => withHierarchy({}, async (page) => {
  assert.equal(await page.textContent('#how-many-pixels'), '1 px');
  await page.keyboard.press(']');
  assert.equal(await page.textContent('#how-many-pixels'), '2 px');
  await page.keyboard.press('[');
  await page.keyboard.press('[');
  assert.equal(await page.textContent('#how-many-pixels'), '0.5 px');
}));

test('a file is opened or dropped, and damage is told in one line', () => visit(browser, EMPTY, {}, async (page) => {
  assert.match(await page.textContent('#wait'), /^Choose or drop a file/);
  const drop = (name, bytes) => page.evaluate(([fileName, text]) => {
    const files = new DataTransfer();
    files.items.add(new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], fileName));
    document.body.dispatchEvent(new DragEvent('drop', { bubbles: true, cancelable: true, dataTransfer: files }));
  }, [name, bytes.toString('base64')]);
  await drop('spot.nmc', NMC);
  await isSettled(page);
  assert.equal(await page.textContent('#name'), 'spot.nmc');
  assert.equal(oddEdges(await trianglesIn(page)), 0);
  await drop('<b>short.nmc', NMC.subarray(0, 5000));
  await page.waitForSelector('#wait:not([hidden]):text("<b>short.nmc: damaged hierarchy of clusters")');
  await page.setInputFiles('#file', { name: 'again.nmc', mimeType: '', buffer: NMC });
  await page.waitForSelector('#name:text("again.nmc")');
  await page.waitForSelector('#wait[hidden]', { state: 'attached' });
}));

test('light, dark, and a phone', () => withHierarchy({ colorScheme: 'dark', viewport: { width: 390, height: 844 } }, async (page) => {
  assert.equal(await page.getAttribute('html', 'data-theme'), 'dark');
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
  assert.ok(await eye.covered(await shoot(page, '#pane-0')) > 0.05);
  assert.ok(await changedBy(page, () => page.selectOption('#theme', 'light')) > 0.3);
}));

test('every control has a name', () => withHierarchy({}, async (page) => {
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select, canvas')]
    .filter((element) => !(element.ariaLabel || element.labels?.length || element.textContent.trim()))
    .map((element) => element.outerHTML));
  assert.deepEqual(nameless, []);
}));

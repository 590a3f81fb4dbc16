// The page of `neural-mesh progression` in a browser: the slider changes the level, its figures follow, and files can be opened.
//
// `scripts/viewer_test` makes progression.html and spot.nmp in PAGES, both of the same closed mesh, dust.nmp, and placed.nmp.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { writeEmptyPage } from '../packed.js';
import { launch, visit } from './browser.js';
import { oddEdges } from './hierarchy.js';
import { makeEye, shoot } from './pixels.js';

const FOLDER = process.env.PAGES;
const PAGE = `${FOLDER}/progression.html`;
const EMPTY = writeEmptyPage('progression.html', FOLDER);

let browser;
let eye;

before(async () => {
  browser = await launch();
  eye = await makeEye(browser);
});
after(() => browser.close());

const withProgression = (options, use) => visit(browser, PAGE, options, async (page) => {
  await nDrawn(page);
  await use(page);
});

/** Waits until pending changes are drawn, and returns the number of faces. */
async function nDrawn(page) {
  await page.waitForFunction(() => Number(document.documentElement.dataset.level) > 0);
  await shoot(page, '.stage');
  return Number(await page.getAttribute('html', 'data-level'));
}

/** Moves the slider to a share of its length. */
async function slide(page, share) {
  await page.evaluate((at) => {
    const slider = document.getElementById('size');
    slider.value = Math.round(at * slider.max);
    slider.dispatchEvent(new Event('input'));
  }, share);
  return nDrawn(page);
}

const trianglesIn = (page) => page.evaluate(() => [...document.getElementById('canvas').drawnTriangles()]);
const figure = async (page, id) => page.textContent(`#figure-${id}`);

async function changedBy(page, act) {
  const shot = await shoot(page, '.stage');
  await act();
  return eye.differing(shot, await shoot(page, '.stage'));
}

test('the original is drawn first, with its figures', () => withProgression({}, async (page) => {
  const covered = await eye.covered(await shoot(page, '#pane-0'));
  assert.ok(covered > 0.1 && covered < 0.9, `${covered} is covered`);
  assert.equal(await page.textContent('#name'), 'spot.ply');
  const figures = await Promise.all(['faces', 'vertices', 'share', 'distance'].map((id) => figure(page, id)));
  assert.deepEqual(figures, ['5,856', '2,930', '100 %', '0']);
  assert.ok(await page.isHidden('#dropped-row'));
}));

test('every level is closed, and smaller to the left', () => withProgression({}, async (page) => {
  const counts = [];
  for (const share of [1, 0.9, 0.7, 0.5, 0.3, 0]) {
    counts.push(await slide(page, share));
    const triangles = await trianglesIn(page);
    assert.equal(triangles.length / 9, counts.at(-1));
    assert.equal(oddEdges(triangles), 0, `${counts.at(-1)} faces`);
    assert.equal(await page.textContent('#how-many'), `${await figure(page, 'faces')} faces`);
  }
  assert.ok(counts.every((n, i) => i === 0 || n < counts[i - 1]) && counts.at(-1) < 20, `${counts}`);
}));

test('keys halve and double the size, and proved levels show their distances', () => withProgression({}, async (page) => {
  await page.keyboard.press('[');
  assert.equal(await nDrawn(page), 2926);
  const first = await page.textContent('#proofs tr:first-child');
  assert.ok(first.startsWith('2,926 faces'), first);
  assert.match(await figure(page, 'distance'), /^0\.\d+, [\d.]+ %$/);
  await page.waitForSelector('#proofs tr:first-child.shown');
  await page.click('#proofs tr:nth-child(3) button');
  const third = await nDrawn(page);
  assert.ok(third < 800, `${third}`);
  await page.waitForSelector('#proofs tr:nth-child(3).shown');
  await slide(page, 0.95);
  assert.equal(await figure(page, 'distance'), 'only at the sizes below');
  await page.keyboard.press(']');
  assert.equal(await nDrawn(page), 5856);
}));

test('every switch changes the picture', () => withProgression({}, async (page) => {
  await slide(page, 0.6);
  for (const key of ['w', 'w', 'f', 'z']) {
    assert.ok(await changedBy(page, () => page.keyboard.press(key)) > 0.01, key);
  }
  assert.ok(await changedBy(page, () => slide(page, 0.4)) > 0.01);
  await page.keyboard.press('a');
  const turned = await shoot(page, '.stage');
  await page.waitForTimeout(500);
  assert.ok(await eye.differing(turned, await shoot(page, '.stage')) > 0.01);
}));

test('a file is opened or dropped, and damage is told in one line', () => visit(browser, EMPTY, {}, async (page) => {
  assert.match(await page.textContent('#wait'), /^Choose or drop a file/);
  const [spot, dust] = ['spot', 'dust'].map((name) => readFileSync(`${FOLDER}/${name}.nmp`));
  const drop = (name, bytes) => page.evaluate(([fileName, text]) => {
    const files = new DataTransfer();
    files.items.add(new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], fileName));
    document.body.dispatchEvent(new DragEvent('drop', { bubbles: true, cancelable: true, dataTransfer: files }));
  }, [name, bytes.toString('base64')]);
  await drop('dust.nmp', dust);
  await page.waitForSelector('#name:text("dust.nmp")');
  assert.equal(await nDrawn(page), 4208);
  await slide(page, 0.3);
  assert.ok(Number(await figure(page, 'dropped')) > 0);
  await drop('<b>short.nmp', spot.subarray(0, 5000));
  await page.waitForSelector('#wait:not([hidden]):text("<b>short.nmp: damaged progression: the checksum does not fit")');
  await page.setInputFiles('#file', { name: 'again.nmp', mimeType: '', buffer: spot });
  await page.waitForSelector('#name:text("again.nmp")');
  await page.waitForSelector('#wait[hidden]', { state: 'attached' });
  assert.equal(await nDrawn(page), 5856);
}));

test('the level shown is saved in each format', () => withProgression({}, async (page) => {
  await slide(page, 0.6);
  const nFaces = await figure(page, 'faces');
  for (const [format, magic] of [['glb', 'glTF'], ['ply', 'ply\n'], ['obj', 'v '], ['stl', '\0\0']]) {
    await page.selectOption('#format', format);
    await page.focus('#canvas');
    const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('s')]);
    assert.equal(download.suggestedFilename(), `spot-${nFaces.replace(',', '')}.${format}`);
    assert.ok(readFileSync(await download.path()).toString('latin1').startsWith(magic), format);
  }
}));

test('a scene is shown with all instances, in the frame', () => visit(browser, EMPTY, {}, async (page) => {
  await page.setInputFiles('#file', { name: 'placed.nmp', mimeType: '', buffer: readFileSync(`${FOLDER}/placed.nmp`) });
  const nFaces = await nDrawn(page);
  const triangles = await trianglesIn(page);
  assert.equal(triangles.length / 9, 3 * nFaces);
  assert.equal(oddEdges(triangles), 0);
  assert.equal(await eye.atBorder(await shoot(page, '.stage')), 0);
}));

test('a flight shows smaller levels and ends where it began', () => withProgression({}, async (page) => {
  const first = await nDrawn(page);
  await page.keyboard.press('v');
  await page.waitForFunction((most) => Number(document.documentElement.dataset.level) < most, first / 8);
  await page.waitForSelector('#fly[aria-pressed="false"]');
  assert.equal(await nDrawn(page), first);
}));

test('light, dark, and a phone', () => withProgression({ colorScheme: 'dark', viewport: { width: 390, height: 844 } }, async (page) => {
  assert.equal(await page.getAttribute('html', 'data-theme'), 'dark');
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
  assert.ok(await eye.covered(await shoot(page, '#pane-0')) > 0.05);
  assert.ok(await changedBy(page, () => page.selectOption('#theme', 'light')) > 0.3);
}));

test('every control has a name', () => withProgression({}, async (page) => {
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select, canvas')]
    .filter((element) => !(element.ariaLabel || element.labels?.length || element.textContent.trim()))
    .map((element) => element.outerHTML));
  assert.deepEqual(nameless, []);
}));

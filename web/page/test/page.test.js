// Tests the page in a browser: opening, sizes, wipe, colours, saving, cancelling, broken files, phones, keys, contrast.
//
// `scripts/web_page` builds the page first. MOCK=1 skips tests that need the real package.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { after, before, test } from 'node:test';
import { namelessControls, recordShifts, walksByKeyboard, weakWords } from '../../../cli/viewer/test/access.js';
import { launch } from '../../../cli/viewer/test/browser.js';
import { makeEye, shoot } from '../../../cli/viewer/test/pixels.js';
import { brokenFiles, fileOf, TINY, waveGlb, zipped } from './files.js';
import { dragFolder, drop, EXAMPLE, isIdle, isShown, onDisk, serve, swipe, visit } from './visit.js';

const REAL = !process.env.MOCK;

let browser;
let eye;
let server;

before(async () => {
  browser = await launch();
  eye = await makeEye(browser);
  server = await serve();
});
after(async () => {
  await browser.close();
  server.close();
});

const withPage = (options, use) => visit(browser, server.url, options, use);
const withExample = (options, use) => withPage(options, async (page) => {
  await page.click(EXAMPLE);
  await isShown(page, '10 %');
  await use(page);
});

const withMesh = (options, use) => withPage(options, async (page) => {
  await drop(page, [fileOf('spot.ply')]);
  await isShown(page, '10 %');
  await use(page);
});

/** Asserts how much of a view an action changes. */
async function changes(page, selector, act, least, most = 1) {
  const shot = await shoot(page, selector);
  await act();
  const share = await eye.differing(shot, await shoot(page, selector));
  assert.ok(share >= least && share <= most, `${share} of the pixels changed`);
}

/** Returns the number of faces in a caption. */
async function facesIn(page, pane) {
  const text = await page.textContent(`#pane-${pane} .caption`);
  return Number(text.match(/([\d,]+) faces/)[1].replaceAll(',', ''));
}

test('an example can be tried at once, also from the disk', async () => {
  for (const url of [server.url, onDisk]) {
    await visit(browser, url, {}, async (page) => {
      await page.click(EXAMPLE);
      await isShown(page, '10 %');
      for (const pane of ['#pane-0', '#pane-1']) {
        const covered = await eye.covered(await shoot(page, pane));
        assert.ok(covered > 0.1 && covered < 0.9, `${covered} of ${pane} is covered`);
      }
    });
  }
});

test('without a network everything works', () => withPage({}, async (page) => {
  await page.context().setOffline(true);
  await drop(page, [fileOf('spot.ply')]);
  await isShown(page, '10 %');
  await page.waitForSelector('html[data-measured="10 %"]');
}));

test('every format is read, dropped and chosen, compressed or not', async () => {
  for (const file of [...TINY, zipped(TINY[0])]) {
    await withPage({}, async (page) => {
      await drop(page, [file]);
      await page.waitForSelector('html[data-open]');
      assert.ok((await page.textContent('#pane-0 .caption')).includes(file.name));
    });
  }
  await withPage({}, async (page) => {
    await page.setInputFiles('#files', { name: 'tetrahedron.ply', mimeType: '', buffer: TINY[1].bytes });
    await page.waitForSelector('html[data-open]');
  });
});

test('a folder brings textures along', { skip: !REAL }, async (t) => {
  const folder = mkdtempSync(`${tmpdir()}/page-`);
  t.after(() => rmSync(folder, { recursive: true }));
  execFileSync('node', [`${import.meta.dirname}/../../../cli/viewer/test/textured.js`, folder]);
  await withPage({}, async (page) => {
    await dragFolder(page, folder);
    await isShown(page, '10 %');
    assert.equal(await page.isChecked('#texture'), true);
    assert.equal(await page.getAttribute('html', 'data-over'), null);
    for (const pane of ['#pane-0', '#pane-1']) {
      const shot = await shoot(page, pane);
      const [red, green, blue] = await Promise.all([0, 1, 2].map((channel) => eye.mostly(shot, channel)));
      const story = JSON.stringify({ pane, red, green, blue });
      assert.ok(green.left > 0.1 && green.right < 0.04 && blue.right > 0.1 && blue.left < 0.04 && red.lower > 0.01 && red.upper < 0.01, story);
    }
    const saved = page.waitForEvent('download');
    await page.click('[data-ending="obj"]');
    const download = await saved;
    assert.equal(download.suggestedFilename(), 'plate-10.zip');
    const names = execFileSync('python3', ['-m', 'zipfile', '-l', await download.path()], { encoding: 'utf8' });
    for (const name of ['plate-10.obj', 'plate.mtl', 'maps/skin.png']) assert.ok(names.includes(name), names);
  });
  await withPage({}, async (page) => {
    await page.setInputFiles('#folder', folder);
    await isShown(page, '10 %');
    assert.equal(await page.isChecked('#texture'), true);
  });
});

test('levels become ready in the background, the slider shows them, and makes others', () => withMesh({}, async (page) => {
  await page.waitForSelector('#levels:not(:has([data-state="missing"]))');
  await changes(page, '#pane-1', async () => {
    await page.click('#levels [data-share="0.02"]');
    await isShown(page, '2 %');
  }, 0.01);
  const least = await facesIn(page, 1);
  assert.ok(Math.abs(least / (await facesIn(page, 0)) - 0.02) < 0.01);
  await page.focus('#share');
  for (let i = 0; i < 20; i++) await page.keyboard.press('ArrowRight');
  const title = await page.textContent('#share-is');
  await isShown(page, title);
  assert.ok(await facesIn(page, 1) > least);
  // While the slider moves, the nearest level is shown.
  await page.evaluate(() => {
    document.getElementById('share').value = 0.9;
    document.getElementById('share').dispatchEvent(new Event('input'));
  });
  await isShown(page, '50 %');
}));

test('a number of faces and a distance are sizes, too', { skip: !REAL }, () => withMesh({}, async (page) => {
  await page.selectOption('#by', 'faces');
  await page.fill('#faces', '1000');
  await page.keyboard.press('Enter');
  await isShown(page, '1,000 faces');
  assert.ok(Math.abs(await facesIn(page, 1) - 1000) <= 20);
  await page.selectOption('#by', 'error');
  await page.fill('#error', '1');
  await page.keyboard.press('Enter');
  await isShown(page, 'within 1 %');
}));

test('options make other results, and recipes say how', () => withMesh({}, async (page) => {
  await page.click('#options summary');
  await page.selectOption('#effort', 'fast');
  await page.check('#subset');
  await page.click('#recipes summary');
  await page.waitForFunction(() => document.querySelector('#languages')?.textContent.includes('--effort fast --subset'));
  const recipes = {
    'Command line': '--ratio 10% --effort fast --subset', Python: 'effort="fast", subset=True', JavaScript: "effort: 'fast', subset: true",
  };
  for (const [name, part] of Object.entries(recipes)) {
    await page.click(`[aria-label="Copy: ${name}"]`);
    await page.waitForFunction((label) => document.querySelector(`button[aria-label="${label}"]`).textContent === 'Copied', `Copy: ${name}`);
    assert.ok((await page.evaluate(() => navigator.clipboard.readText())).includes(part));
  }
}));

test('figures and colours come when the result is measured', () => withExample({}, async (page) => {
  await changes(page, '.stage', async () => {
    await page.keyboard.press('c');
    await page.waitForSelector('html[data-measured="10 %"]');
  }, 0.1);
  assert.ok(await page.isVisible('#scale'));
  assert.equal(await page.locator('#figures tbody:first-of-type tr').count(), 11);
  const last = page.locator('#ticks span:last-child');
  const end = Number(await last.textContent());
  assert.ok(end > 0);
  if (REAL) await changes(page, '.stage', () => page.selectOption('#end', 'max'), 0.001);
  await page.keyboard.press('t');
  await page.keyboard.press('t');
  assert.equal(await page.isChecked('#colours'), !REAL);
}));

test('a headline says size, closeness and whether the surface is closed', { skip: !REAL }, () => withMesh({}, async (page) => {
  await page.waitForSelector('html[data-measured="10 %"]');
  const parts = await page.locator('#headline strong').allTextContents();
  assert.match(parts[0], /^1[0-9]× smaller$/);
  assert.match(parts[1], /^0\.0\d % of its size off$/);
  assert.equal(parts[2], 'closed');
}));

test('nothing on the page moves by itself', () => withPage({}, async (page) => {
  await page.evaluate(recordShifts);
  await drop(page, [fileOf('spot.ply')]);
  await page.waitForSelector('html[data-measured="10 %"]');
  await page.waitForSelector('#levels:not(:has([data-state="missing"]))');
  await isIdle(page);
  assert.deepEqual(await page.evaluate(() => globalThis.shifts), []);
}));

test('every switch changes the picture, and back', () => withMesh({}, async (page) => {
  await page.waitForSelector('#levels:not(:has([data-state="missing"]))');
  await page.waitForSelector('html[data-measured]');
  await isIdle(page);
  const first = await shoot(page, '.stage');
  for (const key of ['w', 'f', 'z', 'v']) {
    await changes(page, '.stage', async () => { await page.keyboard.press(key); await page.waitForTimeout(600); }, 0.003);
    await page.keyboard.press(key);
    await page.waitForTimeout(600);
    const share = await eye.differing(first, await shoot(page, '.stage'));
    assert.ok(share < 0.002, `${share} of the pixels are not as they were after ${key}`);
  }
}));

test('the divider of the wipe follows pointer, touch and keys', () => withMesh({ hasTouch: true }, async (page) => {
  await isIdle(page);
  const value = async () => Number(await page.getAttribute('#divider', 'aria-valuenow'));
  const box = await page.locator('#frame').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await changes(page, '.stage', () => page.mouse.move(box.x + box.width * 0.3, box.y + box.height / 2, { steps: 4 }), 0.001);
  await page.mouse.up();
  assert.ok(Math.abs(await value() - 30) <= 1);
  await page.keyboard.press('ArrowRight');
  assert.ok(Math.abs(await value() - 32) <= 1);
  await page.keyboard.press('End');
  assert.equal(await value(), 100);
  await page.keyboard.press('Home');
  assert.equal(await value(), 0);
  const y = box.y + box.height / 2;
  await swipe(page, { x: box.x + 5, y }, { x: box.x + box.width * 0.7, y });
  assert.ok(Math.abs(await value() - 70) <= 2);
}));

test('every format is written, and begins as it should', () => withMesh({}, async (page) => {
  const begins = { glb: 'glTF', ply: 'ply', off: 'OFF', '3mf': 'PK', gltf: /^PK|^\s*\{/, obj: /^PK|^(#|v|o|mtllib)/, stl: /^[\s\S]{80}/ };
  const endings = await page.locator('#downloads button').evaluateAll((buttons) => buttons.map(({ dataset }) => dataset.ending));
  assert.ok(endings.length >= 5, endings.join());
  for (const ending of endings) {
    const saved = page.waitForEvent('download');
    await page.click(`[data-ending="${ending}"]`);
    const download = await saved;
    assert.match(download.suggestedFilename(), new RegExp(`^spot-10\\.(${ending}|zip)$`));
    const bytes = readFileSync(await download.path());
    assert.ok(bytes.length > 0);
    if (!REAL) continue;
    const head = bytes.toString('latin1', 0, 200);
    const begin = begins[ending];
    assert.ok(typeof begin === 'string' ? head.startsWith(begin) : begin.test(head), `${ending}: ${head.slice(0, 20)}`);
    if (ending === 'stl') assert.equal(bytes.length, 84 + 50 * bytes.readUInt32LE(80));
  }
}));

test('cancelling ends the work at once, and new work can begin, also from the disk', async () => {
  for (const url of [server.url, onDisk]) await visit(browser, url, {}, cancelAndGoOn);
});

async function cancelAndGoOn(page) {
  await drop(page, [waveGlb(REAL ? 400_000 : 2000)]);
  await page.waitForSelector('#work:not(.idle)');
  assert.equal(await page.getAttribute('#progress', 'role'), 'progressbar');
  const began = Date.now();
  await page.click('#cancel');
  await isIdle(page);
  assert.ok(Date.now() - began < 3000);
  await page.click(await page.isVisible(EXAMPLE) ? EXAMPLE : '#levels [data-share="0.1"]');
  await isShown(page, '10 %');
}

test('what cannot be read is said in one line, and the page stays alive', () => withMesh({}, async (page) => {
  // The mock rejects empty files and garbage only.
  const broken = brokenFiles().filter(({ name }) => REAL || /^(empty|garbage)/.test(name));
  assert.ok(broken.length >= (REAL ? 20 : 14));
  for (const file of broken) {
    await page.evaluate(() => { document.getElementById('alert').hidden = true; });
    await drop(page, [file]);
    await page.waitForFunction(() => !document.getElementById('alert').hidden, null, { timeout: 20_000 })
      .catch(() => assert.fail(`${file.name}: nothing is said`));
    const words = await page.textContent('#alert');
    assert.ok(words.trim().length > 5 && !words.includes('\n'), words);
    if (process.env.SHOW) console.log(`${file.name}: ${words}`);
  }
  await drop(page, [fileOf('suzanne.ply')]);
  await page.waitForFunction(() => document.querySelector('#pane-1 .caption').textContent.includes('suzanne-10.ply'));
  assert.equal(await page.isVisible('#alert'), false);
}));

test('what a mesh cannot become is said, too', { skip: !REAL }, () => withMesh({}, async (page) => {
  await page.selectOption('#by', 'error');
  await page.fill('#error', '-1');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#alert:not([hidden])');
}));

test('after a reload the page begins again', () => withMesh({}, async (page) => {
  await page.reload();
  await page.waitForSelector('#welcome:not([hidden])');
  await page.click(EXAMPLE);
  await isShown(page, '10 %');
}));

test('a second mesh takes the place of the first, whatever is going on', () => withMesh({}, async (page) => {
  await drop(page, [fileOf('suzanne.ply')]);
  await page.waitForFunction(() => document.querySelector('#pane-1 .caption').textContent.includes('suzanne-10.ply'));
  await page.waitForSelector('#no-figures[hidden]', { state: 'attached' });
  await isIdle(page);
  if (!REAL) return;
  assert.equal(await facesIn(page, 0), 968);
  const faces = await page.textContent('#figures tbody tr:first-child td');
  assert.equal(Number(faces), await facesIn(page, 1));
}));

test('of several meshes one is shown and the others can be chosen', () => withPage({}, async (page) => {
  await drop(page, [fileOf('suzanne.ply'), fileOf('tiny/tetrahedron.obj')]);
  await page.waitForSelector('html[data-open]');
  assert.ok((await page.textContent('#name')).includes('tetrahedron.obj'));
  await page.selectOption('#meshes', { label: 'suzanne.ply' });
  await page.waitForFunction(() => document.querySelector('#name').textContent.includes('suzanne.ply'));
}));

const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

test('a phone has room for all of it, and fingers do what mice do', () => withPage(PHONE, async (page) => {
  const width = () => page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(await width() <= 390);
  await page.tap(EXAMPLE);
  await isShown(page, '10 %');
  await isIdle(page);
  for (const id of ['#options summary', '#recipes summary', 'label:has(#colours)', 'label:has(#wipe)']) await page.tap(id);
  await page.waitForSelector('html[data-measured="10 %"]');
  assert.ok(await width() <= 390, `the page is ${await width()} wide`);
  assert.ok(await eye.covered(await shoot(page, '.stage')) > 0.05);
  await page.evaluate(() => scrollTo(0, 0));
  await page.evaluate(() => scrollTo(0, 0));
  const box = await page.locator('#canvas').boundingBox();
  const low = box.y + 0.8 * box.height;
  await changes(page, '.stage', () => swipe(page, { x: 60, y: low }, { x: 200, y: low - 40 }), 0.02);
  const small = await page.evaluate(() => [...document.querySelectorAll('button, select, .chip, input[type="range"], input[type="number"]')]
    .filter((one) => one.checkVisibility() && one.getBoundingClientRect().height < 30).map((one) => one.outerHTML));
  assert.deepEqual(small, []);
}));

test('the keyboard reaches every control, and the focus is seen', () => withMesh({}, async (page) => {
  await isIdle(page);
  await page.click('#recipes summary');
  await page.click('#options summary');
  await walksByKeyboard(page);
}));

test('every control has a name', () => withMesh({}, async (page) => {
  assert.deepEqual(await namelessControls(page), []);
}));

for (const colorScheme of ['light', 'dark']) {
  test(`words stand out from what is behind them: ${colorScheme}`, () => withMesh({ colorScheme }, async (page) => {
    await page.keyboard.press('c');
    await page.waitForSelector('html[data-measured="10 %"]');
    for (const summary of await page.locator('summary').all()) await summary.click();
    await drop(page, [{ name: 'empty.ply', bytes: Buffer.alloc(0) }]);
    await page.waitForSelector('#alert:not([hidden])');
    assert.deepEqual(await weakWords(page), []);
  }));
}

// The page in a browser: it draws, every control does what it says, and nothing is asked from elsewhere.
//
// `scripts/viewer_test` makes the pages of PAGES: several.html (closed meshes), open.html (one with marked edges), textured.html, mapped.html
// (a ball with all maps, and one with normals of faces) and large-compare.html.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { namelessControls, recordShifts, walksByKeyboard, weakWords } from './access.js';
import { launch, open, visit } from './browser.js';
import { opening } from './load_time.js';
import { makeEye, shoot } from './pixels.js';

const SEVERAL = `${process.env.PAGES}/several.html`;
const OPEN = `${process.env.PAGES}/open.html`;
const TEXTURED = `${process.env.PAGES}/textured.html`;
const MAPPED = `${process.env.PAGES}/mapped.html`;

let browser;
let eye;

before(async () => {
  browser = await launch();
  eye = await makeEye(browser);
});
after(() => browser.close());

/** Opens a page with the meshes side by side, for comparisons of panes. */
const withPage = (path, options, use) => visit(browser, path, options, async (page) => {
  await page.keyboard.press('v');
  await use(page);
});

/** Holds that a view is again what it was. */
async function isAgain(page, selector, shot) {
  const share = await eye.differing(shot, await shoot(page, selector));
  assert.ok(share < 0.002, `${share} of the pixels are not as they were`);
}

async function changes(page, selector, act, least, most = 1) {
  const shot = await shoot(page, selector);
  await act();
  const share = await eye.differing(shot, await shoot(page, selector));
  assert.ok(share >= least && share <= most, `${share} of the pixels changed`);
}

test('both meshes are drawn', () => withPage(SEVERAL, {}, async (page) => {
  for (const pane of ['#pane-0', '#pane-1']) {
    const covered = await eye.covered(await shoot(page, pane));
    assert.ok(covered > 0.1 && covered < 0.9, `${covered} of ${pane} is covered`);
  }
}));

test('a headline says size, closeness and whether the surface is closed', async () => {
  await withPage(SEVERAL, {}, async (page) => {
    const parts = () => page.locator('#headline strong').allTextContents();
    assert.match((await parts()).join(), /^\d+× smaller,0\.\d+ % of its size off,closed$/);
  });
  await withPage(OPEN, {}, async (page) => assert.equal(await page.locator('#headline .poor strong').last().textContent(), 'holes'));
});

test('the best value of each row is marked', () => withPage(SEVERAL, {}, async (page) => {
  const best = await page.locator('#figures tbody:first-of-type tr').evaluateAll((rows) => rows.map((row) => (
    [row.cells[0].firstChild.textContent, [...row.cells].findIndex((cell) => cell.classList.contains('best'))])));
  // The results have 2, 10 and 50 percent of the vertices.
  assert.equal(Object.fromEntries(best).Triangles, 1);
  assert.equal(Object.fromEntries(best)['Mean distance'], 3);
}));

test('a map shows what the eye notices', () => withPage(SEVERAL, {}, async (page) => {
  await page.waitForFunction(() => document.getElementById('flip-map').width > 300);
  assert.ok(await eye.covered(await shoot(page, '#flip-map')) > 0.05);
}));

test('every switch changes the picture, and back', () => withPage(SEVERAL, {}, async (page) => {
  const first = await shoot(page, '.stage');
  for (const key of ['c', 'w', 'f', 'z', 'v', 'q']) {
    await changes(page, '.stage', () => page.keyboard.press(key), 0.01);
    await page.keyboard.press(key);
    await isAgain(page, '.stage', first);
  }
}));

test('a ring stands where the meshes are farthest apart, and the camera goes there', () => withPage(SEVERAL, {}, async (page) => {
  const first = await shoot(page, '.stage');
  await changes(page, '.stage', () => page.keyboard.press('x'), 0.05);
  // Without the ring some pixels change, and the camera stays.
  await changes(page, '#pane-1', () => page.keyboard.press('x'), 0.0005, 0.05);
  await page.keyboard.press('r');
  await isAgain(page, '.stage', first);
}));

test('marked edges are drawn and counted', () => withPage(OPEN, {}, async (page) => {
  assert.match(await page.textContent('#pane-1 .marks'), /^\d+ open/);
  await changes(page, '#pane-1', () => page.keyboard.press('m'), 0.0005, 0.2);
}));

test('of switches pressed at once all hold', async () => {
  let asked;
  await withPage(OPEN, {}, async (page) => {
    await page.keyboard.press('m');
    await page.keyboard.press('w');
    asked = await shoot(page, '.stage');
  });
  await withPage(OPEN, {}, async (page) => {
    await page.evaluate(() => ['wire', 'marks'].forEach((name) => document.querySelector(`[data-switch="${name}"]`).click()));
    await isAgain(page, '.stage', asked);
  });
});

test('a result that could not be shown is tried again', async () => {
  const { page, complaints } = await open(browser, SEVERAL);
  const hide = (from, to) => page.evaluate(([before, after]) => {
    document.querySelectorAll(`[data-of="${before}"]`).forEach((part) => { part.dataset.of = after; });
  }, [from, to]);
  await hide('surface-2', 'hidden');
  await page.click('#next');
  await page.waitForFunction(() => document.getElementById('wait').textContent.includes('cannot be shown'));
  await hide('hidden', 'surface-2');
  await page.click('#previous');
  await page.waitForSelector('#wait[hidden]', { state: 'attached' });
  await page.click('#next');
  await page.waitForSelector('html[data-result="2"]');
  assert.equal(complaints.length, 1);
  await page.context().close();
});

test('the slider changes the result and its column', () => withPage(SEVERAL, {}, async (page) => {
  await page.focus('#result');
  await changes(page, '#pane-1', async () => {
    await page.keyboard.press('ArrowRight');
    await page.waitForSelector('html[data-result="2"]');
  }, 0.01);
  assert.match(await page.textContent('#which'), /^2 of 3: /);
  const column = page.locator('#figures thead th.shown');
  assert.equal(await column.textContent(), await page.textContent('#pane-1 .name'));
  await page.click('#previous');
  await page.waitForSelector('html[data-result="1"]');
}));

test('keys and mouse move both cameras as one', () => withPage(SEVERAL, {}, async (page) => {
  await page.focus('#canvas');
  const first = await shoot(page, '.stage');
  for (const key of ['ArrowLeft', 'ArrowUp', 'Shift+ArrowRight', '+']) {
    for (const pane of ['#pane-0', '#pane-1']) await changes(page, pane, () => page.keyboard.press(key), 0.01);
  }
  await page.keyboard.press('Home');
  await isAgain(page, '.stage', first);
  const box = await page.locator('#pane-1').boundingBox();
  const drag = async () => {
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2, { steps: 3 });
    await page.mouse.up();
  };
  await changes(page, '#pane-0', drag, 0.01);
  await changes(page, '#pane-0', () => page.mouse.wheel(0, -300), 0.01);
}));

test('AltGr writes characters and presses no switch', () => withPage(SEVERAL, {}, async (page) => {
  await page.focus('#canvas');
  const first = await shoot(page, '.stage');
  const press = (key) => page.evaluate((pressed) => {
    const held = { modifierAltGraph: true, ctrlKey: true, altKey: true };
    document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: pressed, bubbles: true, ...held }));
  }, key);
  await press('c');
  await isAgain(page, '.stage', first);
  await changes(page, '.stage', () => press('+'), 0.01);
}));

test('the colours end where the reader says', () => withPage(SEVERAL, {}, async (page) => {
  await page.keyboard.press('c');
  const last = page.locator('#ticks span:last-child');
  const before = Number(await last.textContent());
  await changes(page, '.stage', () => page.selectOption('#end', 'max'), 0.01);
  assert.ok(Number(await last.textContent()) > before);
  await page.selectOption('#end', 'own');
  await changes(page, '.stage', () => page.fill('#own', String(before / 4)), 0.01);
  assert.ok(Math.abs(Number(await last.textContent()) - before / 4) < 0.02 * before);
  await page.selectOption('#unit', 'own');
  assert.ok(Number(await page.inputValue('#own')) > 0);
}));

/** Holds that a pane shows the plate of textured.js: green on the left, blue on the right, red below where its materials are known. */
async function showsTexture(page, pane, hasMaterials = true) {
  const shot = await shoot(page, pane);
  const [red, green, blue] = await Promise.all([0, 1, 2].map((channel) => eye.mostly(shot, channel)));
  const story = JSON.stringify({ pane, red, green, blue });
  assert.ok(green.left > 0.1 && green.right < 0.02 && blue.right > 0.1 && blue.left < 0.02, story);
  assert.ok((red.lower > 0.02) === hasMaterials && red.upper < 0.01, story);
}

async function showsNoTexture(page, pane) {
  const shot = await shoot(page, pane);
  for (const channel of [1, 2]) {
    const { left, right } = await eye.mostly(shot, channel);
    assert.ok(left + right < 0.02, `${pane}: ${left} and ${right} of channel ${channel}`);
  }
}

test('textures are shown where the meshes have them', () => withPage(TEXTURED, {}, async (page) => {
  assert.equal(await page.isChecked('#texture'), true);
  for (const pane of ['#pane-0', '#pane-1']) await showsTexture(page, pane);
  assert.equal(await page.textContent('#pane-1 .of-cover'), '');
  await page.click('#next');
  await page.waitForSelector('html[data-result="2"]');
  await showsTexture(page, '#pane-1', false);
  assert.equal(await page.textContent('#pane-1 .of-cover'), 'texture of the original');
  await page.click('#next');
  await page.waitForSelector('html[data-result="3"]');
  await showsTexture(page, '#pane-0');
  await showsNoTexture(page, '#pane-1');
  assert.ok(await page.isVisible('#pane-1 .of-cover:text("plain")'));
}));

test('the texture gives way to other colours, facets and edges, and comes back', () => withPage(TEXTURED, {}, async (page) => {
  const first = await shoot(page, '.stage');
  // The light is even, so facets show little.
  for (const [key, least] of [['w', 0.005], ['f', 0.0005]]) {
    await changes(page, '.stage', () => page.keyboard.press(key), least);
    await page.keyboard.press(key);
    await isAgain(page, '.stage', first);
  }
  await changes(page, '.stage', () => page.keyboard.press('c'), 0.05);
  assert.equal(await page.isChecked('#texture'), false);
  await page.keyboard.press('t');
  await isAgain(page, '.stage', first);
  await page.keyboard.press('t');
  await showsNoTexture(page, '#pane-0');
}));

test('maps of a material are shown, and surfaces are shaded by stored normals', () => withPage(MAPPED, {}, async (page) => {
  const green = await eye.mostly(await shoot(page, '#pane-0'), 1);
  assert.ok(green.left > 0.004 && green.right > 0.004, JSON.stringify(green));
  await changes(page, '#pane-0', () => page.keyboard.press('t'), 0.05);
  // Facets are there already where normals are those of faces.
  const [smooth, flat] = [await shoot(page, '#pane-0'), await shoot(page, '#pane-1')];
  await page.keyboard.press('f');
  const [more, less] = [await eye.differing(smooth, await shoot(page, '#pane-0')), await eye.differing(flat, await shoot(page, '#pane-1'))];
  assert.ok(more > 0.01 && less < 0.005, `${more} and ${less} of the pixels changed`);
  await changes(page, '#pane-1', () => page.keyboard.press('c'), 0.05);
}));

test('without a texture there is no switch for it', () => withPage(SEVERAL, {}, async (page) => {
  assert.equal(await page.isVisible('label:has(#texture)'), false);
  const first = await shoot(page, '.stage');
  await page.keyboard.press('t');
  await isAgain(page, '.stage', first);
}));

test('light and dark, as the system says and as the reader says', () => withPage(SEVERAL, { colorScheme: 'dark' }, async (page) => {
  const theme = () => page.getAttribute('html', 'data-theme');
  assert.equal(await theme(), 'dark');
  await changes(page, '.stage', () => page.selectOption('#theme', 'light'), 0.3);
  assert.equal(await theme(), 'light');
}));

test('a phone has room for all of it', () => withPage(SEVERAL, { viewport: { width: 390, height: 844 }, hasTouch: true }, async (page) => {
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
  assert.ok(await eye.covered(await shoot(page, '#pane-1')) > 0.05);
}));

/** Opens all details at once; runs in the page. */
function openAll() {
  for (const one of document.querySelectorAll('details')) Object.assign(one, { name: '', open: true });
}

test('every control has a name, and the keyboard reaches all of them', () => withPage(MAPPED, {}, async (page) => {
  await page.evaluate(openAll);
  await page.keyboard.press('c');
  assert.deepEqual(await namelessControls(page), []);
  await walksByKeyboard(page);
}));

for (const colorScheme of ['light', 'dark']) {
  test(`words stand out from what is behind them: ${colorScheme}`, async () => {
    for (const path of [SEVERAL, OPEN, TEXTURED]) {
      await withPage(path, { colorScheme }, async (page) => {
        for (const key of ['c', 'm']) await page.keyboard.press(key);
        await page.evaluate(openAll);
        assert.deepEqual(await weakWords(page), []);
      });
    }
  });
}

test('nothing on the page moves by itself', () => withPage(SEVERAL, {}, async (page) => {
  await page.evaluate(recordShifts);
  await page.waitForFunction(() => document.getElementById('flip-map').width > 300);
  for (const result of [2, 3]) {
    await page.click('#next');
    await page.waitForSelector(`html[data-result="${result}"]`);
  }
  await page.waitForTimeout(500);
  assert.deepEqual(await page.evaluate(() => globalThis.shifts), []);
}));

test('a large page opens within three seconds', async (context) => {
  const { size, drawn, total } = await opening(browser, `${process.env.PAGES}/large-compare.html`);
  context.diagnostic(`${size.toFixed(1)} MB, drawn after ${drawn} ms, ${total} ms of the page's own thread`);
  // Time of the processor holds on a busy machine as well.
  assert.ok(size > 25 && total < 3000, `${size} MB, ${total} ms`);
});

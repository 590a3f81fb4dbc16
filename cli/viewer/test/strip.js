// Takes a picture of pages of `neural-mesh compare` with two results each, a row per page: node strip.js PICTURE.png PAGE...

import { launch, open } from './browser.js';

const [picture, ...paths] = process.argv.slice(2);
const SIDE = 264;
const browser = await launch();

/** Returns the pictures of the original and both results, with faces and FLIP errors. */
async function take(path) {
  const { page } = await open(browser, path, { viewport: { width: 1120, height: 620 }, colorScheme: 'light' });
  const { original, results } = JSON.parse(await page.textContent('#comparison')).comparison;
  await page.keyboard.press('v');
  await page.evaluate(() => {
    for (const words of document.querySelectorAll('.caption')) words.style.visibility = 'hidden';
    for (const box of document.querySelectorAll('.stage, .pane')) Object.assign(box.style, { background: '#f1f4f3', border: 0 });
    document.querySelectorAll('.pane').forEach((pane) => { pane.style.background = 'none'; });
  });
  const shoot = async (pane, words) => {
    await page.waitForTimeout(800);
    return { words, image: (await page.locator(pane).screenshot()).toString('base64') };
  };
  const wordsOf = (name, { faces, values }) => [name, `${faces.toLocaleString('en-US')} triangles, FLIP ${values.flip.toFixed(3)}`];
  const shots = [await shoot('#pane-0', ['original', `${original.faces.toLocaleString('en-US')} triangles`]), await shoot('#pane-1', wordsOf('neural-mesh', results[0]))];
  await page.keyboard.press(']');
  shots.push(await shoot('#pane-1', wordsOf('gltfpack -sa', results[1])));
  await page.context().close();
  return shots;
}

const shots = [];
for (const path of paths) shots.push(...await take(path));
const context = await browser.newContext({ viewport: { width: 3 * SIDE, height: 100 } });
const page = await context.newPage();
const figures = shots.map(({ words: [name, size], image }) => (
  `<figure><img src="data:image/png;base64,${image}"><figcaption><b>${name}</b><br>${size}</figcaption></figure>`));
await page.setContent(`<style>
body { margin: 0; display: grid; grid-template-columns: repeat(3, ${SIDE}px); background: #f1f4f3; font: 14px "DejaVu Sans", sans-serif; color: #14201d }
figure { margin: 0; padding-bottom: 8px; text-align: center } img { width: ${SIDE}px; height: ${SIDE}px; object-fit: contain; display: block }
</style>${figures.join('')}`);
await page.screenshot({ path: picture, fullPage: true });
await browser.close();

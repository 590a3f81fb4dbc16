// Takes the pictures of the examples: node examples.js writes src/examples/*.webp. The page must be built.

import { writeFileSync } from 'node:fs';
import { launch } from '../../../cli/viewer/test/browser.js';
import { EXAMPLE_NAMES, isIdle, isShown, onDisk, open } from './visit.js';

const browser = await launch();
for (const name of EXAMPLE_NAMES) {
  const { page } = await open(browser, onDisk, { viewport: { width: 1000, height: 800 }, colorScheme: 'light' });
  await page.click(`[data-example="${name}"]`);
  await isShown(page, '10 %');
  await isIdle(page);
  // All of the original, without words.
  await page.focus('#divider');
  await page.keyboard.press('End');
  await page.evaluate(() => {
    for (const part of document.querySelectorAll('.caption, .divider, .work')) part.style.visibility = 'hidden';
    document.querySelector('.stage').style.background = 'none';
  });
  const shot = await page.locator('#canvas').screenshot();
  const text = await page.evaluate(async (base64) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]));
    const canvas = Object.assign(document.createElement('canvas'), { width: 352, height: 264 });
    const side = 0.85 * Math.min(image.width, (image.height * 4) / 3);
    canvas.getContext('2d').drawImage(image, (image.width - side) / 2, (image.height - 0.75 * side) / 2, side, 0.75 * side, 0, 0, 352, 264);
    return canvas.toDataURL('image/webp', 0.8);
  }, shot.toString('base64'));
  writeFileSync(`${import.meta.dirname}/../src/examples/${name.toLowerCase()}.webp`, Buffer.from(text.split(',')[1], 'base64'));
  await page.context().close();
}
await browser.close();

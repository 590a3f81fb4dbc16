// Takes pictures of the page with a bust: node picture.js FOLDER writes page.png, at desktop size, and page-phone.png.

import { launch } from '../../../cli/viewer/test/browser.js';
import { fileOf } from './files.js';
import { drop, isIdle, isShown, onDisk, open } from './visit.js';

const folder = process.argv[2];
const browser = await launch();

/** Opens the bust at the coarsest level and takes a picture after the measurement. */
async function take(name, options, act) {
  const { page } = await open(browser, onDisk, options);
  await drop(page, [fileOf('nefertiti.ply')]);
  await page.waitForSelector('#levels:not(:has([data-state="missing"]))');
  await page.click('#levels [data-share="0.02"]');
  await isShown(page, '2 %');
  await page.waitForSelector('html[data-measured="2 %"]');
  await act(page);
  await isIdle(page);
  await page.waitForTimeout(1000);
  await page.screenshot({ path: `${folder}/${name}.png` });
  await page.context().close();
}

await take('page', { viewport: { width: 1200, height: 740 }, colorScheme: 'light' }, async () => {});
await take('page-phone', { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, colorScheme: 'dark' }, async () => {});
await browser.close();

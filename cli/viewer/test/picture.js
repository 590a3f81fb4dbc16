// Takes a picture of a page: node picture.js PAGE PICTURE.png

import { launch, open } from './browser.js';

const [path, picture] = process.argv.slice(2);
const browser = await launch();
const { page } = await open(browser, path, { viewport: { width: 1360, height: 840 }, colorScheme: 'light' });
// The second of the results, with its edges.
for (const key of [']', 'w']) await page.keyboard.press(key);
await page.waitForTimeout(500);
await page.screenshot({ path: picture });
await browser.close();

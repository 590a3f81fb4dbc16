// How long a page takes until it has drawn, and the longest time in which it does not answer: node load_time.js PAGE...

import { statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { launch } from './browser.js';

const browser = await launch();
for (const path of process.argv.slice(2)) {
  const page = await browser.newPage();
  await page.addInitScript(() => {
    globalThis.tasks = [];
    new PerformanceObserver((list) => tasks.push(...list.getEntries().map((task) => [task.startTime, task.duration])))
      .observe({ type: 'longtask', buffered: true });
  });
  await page.goto(pathToFileURL(path).href);
  await page.waitForSelector('html[data-state="ready"]', { timeout: 300_000 });
  await page.waitForTimeout(2000);
  const { drawn, parsed, tasks } = await page.evaluate(() => ({
    drawn: performance.getEntriesByName('first-draw')[0].startTime,
    parsed: performance.getEntriesByType('navigation')[0].domInteractive,
    tasks: globalThis.tasks,
  }));
  const longest = Math.max(0, ...tasks.map(([, duration]) => duration));
  const size = (statSync(path).size / 2 ** 20).toFixed(1);
  console.log(`${path}: ${size} MiB, parsed ${Math.round(parsed)} ms, drawn ${Math.round(drawn)} ms, longest task ${longest} ms`);
  console.log(`  tasks over 50 ms (start, duration): ${tasks.map((task) => task.map(Math.round).join(' ')).join(', ') || 'none'}`);
  await page.close();
}
await browser.close();

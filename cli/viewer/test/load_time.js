// Measures the time until pages are drawn, and the longest task of their main thread: node load_time.js PAGE...
//
// Wall-clock time includes other work of the machine; processor time of the thread does not.

import { statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { launch } from './browser.js';

/** Returns megabytes of a page, milliseconds until it is drawn, and processor milliseconds of its main thread: total and longest task. */
export async function opening(browser, path) {
  const page = await browser.newPage();
  await browser.startTracing(page, { categories: ['devtools.timeline', 'disabled-by-default-devtools.timeline'] });
  await page.goto(pathToFileURL(path).href);
  await page.waitForSelector('html[data-state="ready"]', { timeout: 300_000 });
  await page.waitForTimeout(1000);
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const drawn = await page.evaluate(() => performance.getEntriesByName('first-draw')[0].startTime);
  await page.close();
  const tasks = tasksOfThePage(traceEvents);
  const [total, longest] = [tasks.reduce((sum, task) => sum + task, 0), Math.max(...tasks)].map(Math.round);
  return { size: statSync(path).size / 1e6, drawn: Math.round(drawn), total, longest };
}

/** Returns the processor milliseconds of the tasks of the page's main thread, the busiest of its kind. */
function tasksOfThePage(events) {
  const threads = events.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain');
  const isTask = ({ name }) => name === 'RunTask';
  const ofThread = ({ pid, tid }) => events.filter((event) => event.pid === pid && event.tid === tid && isTask(event));
  const times = threads.map((thread) => ofThread(thread).map(({ tdur = 0 }) => tdur / 1000));
  const sum = (list) => list.reduce((total, time) => total + time, 0);
  return times.sort((a, b) => sum(b) - sum(a))[0];
}

if (import.meta.filename === process.argv[1]) {
  const browser = await launch();
  for (const path of process.argv.slice(2)) {
    const { size, drawn, total, longest } = await opening(browser, path);
    console.log(`${path}: ${size.toFixed(1)} MB, drawn after ${drawn} ms; main thread ${total} ms in all, ${longest} ms at most`);
  }
  await browser.close();
}

// How long pages take until they have drawn, and the longest task of the thread that answers: node load_time.js PAGE...
//
// Wall-clock time holds whatever else the machine does; the thread's own time does not.

import { statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { launch } from './browser.js';

const browser = await launch();
for (const path of process.argv.slice(2)) {
  const page = await browser.newPage();
  await browser.startTracing(page, { categories: ['devtools.timeline', 'disabled-by-default-devtools.timeline'] });
  await page.goto(pathToFileURL(path).href);
  await page.waitForSelector('html[data-state="ready"]', { timeout: 300_000 });
  await page.waitForTimeout(1000);
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const drawn = await page.evaluate(() => performance.getEntriesByName('first-draw')[0].startTime);
  const tasks = tasksOfThePage(traceEvents);
  const [total, longest] = [tasks.reduce((sum, task) => sum + task, 0), Math.max(...tasks)].map(Math.round);
  const size = (statSync(path).size / 2 ** 20).toFixed(1);
  console.log(`${path}: ${size} MiB, drawn after ${Math.round(drawn)} ms; main thread ${total} ms in all, ${longest} ms at most`);
  await page.close();
}
await browser.close();

/** Milliseconds of processor time of the tasks of the page's own thread, the busiest of its kind. */
function tasksOfThePage(events) {
  const threads = events.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain');
  const isTask = ({ name }) => name === 'RunTask';
  const ofThread = ({ pid, tid }) => events.filter((event) => event.pid === pid && event.tid === tid && isTask(event));
  const times = threads.map((thread) => ofThread(thread).map(({ tdur = 0 }) => tdur / 1000));
  const sum = (list) => list.reduce((total, time) => total + time, 0);
  return times.sort((a, b) => sum(b) - sum(a))[0];
}

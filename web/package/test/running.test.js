// Tests how calls run: in workers and in this thread, with progress, aborted, many at once, and without workers.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import test from 'node:test';
import { setTimeout as wait } from 'node:timers/promises';

import { built } from './built.js';
import { torus } from './shapes.js';

const { simplify } = await built('index');
const small = torus();
const large = torus(500, 250);
const aborted = { name: 'AbortError' };

test('a worker and this thread give the same', async () => {
  const there = await simplify(small, { faces: 500 });
  const here = await simplify(small, { faces: 500 }, { worker: false });
  assert.deepEqual(here.results, there.results);
});

test('progress is told and grows to the end', async () => {
  for (const worker of [true, false]) {
    const shares = [];
    await simplify(large, { ratio: 0.1 }, { worker, progress: (share, part) => shares.push([share, part]) });
    assert.ok(shares.length > 3, `${shares.length}`);
    assert.ok(shares.every(([share]) => share >= 0 && share <= 1));
    assert.ok(shares.every(([share, part], i) => i === 0 || part > shares[i - 1][1] || (part === shares[i - 1][1] && share >= shares[i - 1][0])));
  }
});

test('this thread goes on while a worker runs', async () => {
  let ticks = 0;
  const timer = setInterval(() => ticks++, 5);
  await simplify(large, { ratio: 0.1 });
  clearInterval(timer);
  assert.ok(ticks > 10, `${ticks}`);
});

test('an abort ends a worker at once, and the next call works', async () => {
  const abort = new AbortController();
  const run = simplify(large, { ratio: 0.01 }, { signal: abort.signal });
  await wait(150);
  const from = performance.now();
  abort.abort();
  await assert.rejects(run, aborted);
  assert.ok(performance.now() - from < 50, `${performance.now() - from} ms`);
  assert.equal((await simplify(small, { faces: 500 })).results.length, 1);
});

test('an abort before the call, and one while a worker starts', async () => {
  await assert.rejects(simplify(small, { faces: 500 }, { signal: AbortSignal.abort() }), aborted);
  const abort = new AbortController();
  const run = simplify(small, { faces: 500 }, { signal: abort.signal });
  abort.abort();
  await assert.rejects(run, aborted);
});

test('an abort rejects with the reason that was given', async () => {
  await assert.rejects(simplify(large, { ratio: 0.1 }, { signal: AbortSignal.timeout(20) }), { name: 'TimeoutError' });
});

test('an abort is heard here between calls of progress', async () => {
  const abort = new AbortController();
  const run = simplify(large, { ratio: 0.1 }, { worker: false, signal: abort.signal, progress: (share) => share > 0.1 && abort.abort() });
  await assert.rejects(run, aborted);
  assert.equal((await simplify(small, { faces: 500 }, { worker: false })).results.length, 1);
});

test('an error of the listener is that of the call', async () => {
  for (const worker of [true, false]) {
    const progress = () => { throw new Error('enough'); };
    await assert.rejects(simplify(large, { ratio: 0.1 }, { worker, progress }), { name: 'Error', message: 'enough' });
  }
});

test('many calls at once have an answer each', async () => {
  const sizes = Array.from({ length: 20 }, (_, i) => 200 + 20 * i);
  const runs = await Promise.all(sizes.map((faces) => simplify(small, { faces })));
  runs.forEach(({ results }, i) => assert.ok(results[0].faces.length <= 3 * sizes[i]));
});

test('aborted calls leave the others alone', async () => {
  const runs = Array.from({ length: 12 }, (_, i) => {
    const abort = new AbortController();
    const run = simplify(small, { faces: 500 }, { signal: abort.signal });
    if (i % 2) abort.abort();
    return run.then(() => 'done', (error) => error.name);
  });
  assert.deepEqual(await Promise.all(runs), Array.from({ length: 12 }, (_, i) => (i % 2 ? 'AbortError' : 'done')));
});

/** Runs a program with the package in a process of its own, and returns what it prints. */
function runAlone(lines) {
  const index = new URL('../dist/index.js', import.meta.url).href;
  const program = `const { simplify } = await import('${index}');
    const input = { positions: [0,0,0, 1,0,0, 0,1,0, 0,0,1], faces: [0,2,1, 0,1,3, 1,2,3, 0,3,2] };
    ${lines}`;
  return execFileSync(process.execPath, ['--input-type=module', '--eval', program], { encoding: 'utf8', timeout: 60000 }).trim();
}

test('a process ends by itself', () => {
  assert.equal(runAlone("console.log((await simplify(input, { ratio: 1 })).results[0].faces.length);"), '12');
});

test('where a page refuses workers, calls run here', () => {
  // Imitates a page: there is a document, and its policy forbids workers.
  const page = `globalThis.document = {};
    globalThis.Worker = class { constructor() { throw new Error('SecurityError'); } };`;
  assert.equal(runAlone(`${page} console.log((await simplify(input, { ratio: 1 })).results[0].faces.length);`), '12');
  const late = `globalThis.document = {};
    globalThis.Worker = class { constructor() { setTimeout(() => this.onerror({ message: '' })); } postMessage() {} terminate() {} };`;
  assert.equal(runAlone(`${late} console.log((await Promise.all([1, 2, 3, 4, 5, 6].map(() => simplify(input, { ratio: 1 })))).length);`), '6');
});

test('without DecompressionStream, Node unpacks', () => {
  assert.equal(runAlone('delete globalThis.DecompressionStream; console.log((await simplify(input, { ratio: 1 })).results[0].faces.length);'), '12');
});

// Manages the workers of one WebAssembly module: each runs one request at a time, and more start while more requests run.

import { startThread } from './thread.js';

/** Returns the largest number of workers, one per core; further requests wait. */
const maxWorkers = () => globalThis.navigator?.hardwareConcurrency ?? 4;

/**
 * Creates a pool that starts workers on demand.
 *
 * @param {string} text program of the workers
 * @param {() => Promise<WebAssembly.Module>} getModule
 * @returns {{take: () => Promise<object|null>, giveBack: (thread: object) => void, lose: (thread: object) => void}} `take` gives a thread
 *   that is ready, or null if workers are not allowed; `lose` ends one that must not be used again
 */
export function makePool(text, getModule) {
  const idle = [];
  const waiting = [];
  let running = 0;
  let refused = false;

  async function start() {
    const module = await getModule();
    try {
      return await startWith(text, module);
    } catch {
      // A page's policy may forbid workers or sending a module. It does not change while the page is open.
      refused = true;
      return null;
    }
  }

  async function take() {
    if (refused) return null;
    if (idle.length > 0) return idle.pop();
    if (running >= maxWorkers()) return new Promise((resolve) => waiting.push(resolve));
    running++;
    try {
      const thread = await start();
      if (!thread) dropOne();
      return thread;
    } catch (error) {
      dropOne();
      throw error;
    }
  }

  /** Counts down the workers and lets a waiting request start a new one. */
  function dropOne() {
    running--;
    if (refused) waiting.splice(0).forEach((next) => next(null));
    const next = waiting.shift();
    if (next) take().then(next, () => next(null));
  }

  function giveBack(thread) {
    thread.release();
    if (waiting.length > 0) waiting.shift()(thread);
    else if (idle.length > 0) lose(thread);
    else idle.push(thread);
  }

  function lose(thread) {
    thread.end();
    dropOne();
  }

  return { take, giveBack, lose };
}

/** Starts a worker and waits until it has received the module. */
async function startWith(text, module) {
  const thread = await startThread(text);
  thread.hold();
  try {
    await new Promise((resolve, reject) => {
      thread.onMessage = resolve;
      thread.onError = reject;
      thread.post({ module });
    });
  } catch (error) {
    thread.end();
    throw error;
  } finally {
    thread.started();
    thread.release();
  }
  return thread;
}

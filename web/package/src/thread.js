// Wraps workers of browsers and of Node, Deno and Bun in one interface.

/** Returns whether workers are those of `node:worker_threads`: in Node, Deno and Bun. */
export const inNode = () => typeof globalThis.process?.versions?.node === 'string' && typeof document === 'undefined';

/**
 * Starts a worker.
 *
 * @param {string} text its program
 * @returns {Promise<{post: Function, end: Function, hold: Function, release: Function, onMessage: Function, onError: Function}>} `hold`
 *   keeps the process alive until `release`; `onMessage` and `onError` are set by the caller
 * @throws if workers are not allowed
 */
export async function startThread(text) {
  return inNode() ? startNodeThread(text) : startPageThread(text);
}

/** Imports a module of Node in a way that bundlers for browsers do not see. */
export function importNode(name) {
  return import(/* webpackIgnore: true */ /* @vite-ignore */ name);
}

async function startNodeThread(text) {
  const { Worker } = await importNode('node:worker_threads');
  const worker = new Worker(text, { eval: true });
  const thread = threadOf(worker);
  thread.hold = () => worker.ref();
  thread.release = () => worker.unref();
  worker.on('message', (message) => thread.onMessage(message));
  worker.on('error', (error) => thread.onError(error));
  worker.on('messageerror', (error) => thread.onError(error));
  thread.release();
  return thread;
}

function startPageThread(text) {
  const url = URL.createObjectURL(new Blob([text], { type: 'text/javascript' }));
  try {
    // A classic script, as a page opened from disk may not start a module worker.
    const worker = new Worker(url);
    const thread = threadOf(worker);
    worker.onmessage = ({ data }) => thread.onMessage(data);
    worker.onerror = (event) => thread.onError(new Error(event.message || 'the worker did not start'));
    worker.onmessageerror = () => thread.onError(new Error('a message did not reach the worker'));
    // The URL must stay valid until the worker has loaded it, which its first answer shows.
    thread.started = () => URL.revokeObjectURL(url);
    return thread;
  } catch (error) {
    URL.revokeObjectURL(url);
    throw error;
  }
}

function threadOf(worker) {
  const nothing = () => {};
  return {
    post: (message, moved) => worker.postMessage(message, moved),
    end: () => worker.terminate(),
    hold: nothing,
    release: nothing,
    started: nothing,
    onMessage: nothing,
    onError: nothing,
  };
}

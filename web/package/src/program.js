// Runs calls to a WebAssembly program, in a worker or in this thread.

import { NeuralMeshError } from './error.js';
import { makeRunner, trapLine } from './instance.js';
import { packMessage, planMessage, unpackMessage } from './message.js';
import { makePool } from './pool.js';
import { compilePacked } from './unpack.js';

/**
 * Creates a program from its packed text; the first call unpacks it.
 *
 * @param {string} packed base64 of the gzipped WebAssembly
 * @param {string} workerText program of its workers
 * @returns {{call: Function, instance: Function}} see {@link callProgram}; `instance` creates an instance for synchronous calls
 */
export function makeProgram(packed, workerText) {
  let module = null;
  const getModule = () => (module ??= compilePacked(packed));
  const pool = makePool(workerText, getModule);
  return {
    call: (request, control) => callProgram(pool, getModule, request, control),
    instance: async () => {
      const compiled = await getModule();
      return () => makeDirectCall(compiled);
    },
  };
}

/**
 * Runs one request.
 *
 * @param {object} request JSON whose typed arrays are sent along
 * @param {{progress?: Function, signal?: AbortSignal, worker?: boolean}} control
 * @returns {Promise<{json: object, array: Function}>} the answer, see `unpackMessage`
 * @throws {NeuralMeshError} the program's error
 * @throws the signal's reason, an `AbortError` by default
 */
async function callProgram(pool, getModule, request, { progress, signal, worker = true } = {}) {
  signal?.throwIfAborted();
  const message = packMessage(request);
  const thread = worker ? await untilAborted(pool.take(), signal, pool.giveBack) : null;
  const answer = thread
    ? await runInThread(pool, thread, message, progress, signal)
    : await runHere(await getModule(), message, progress, signal);
  return readAnswer(answer);
}

/** Creates a function for synchronous calls. It is unusable after a trap. */
function makeDirectCall(module) {
  const { imports, run } = makeRunner();
  const instance = new WebAssembly.Instance(module, imports);
  return (request) => readAnswer(run(instance, planMessage(request), () => false));
}

/** Waits for a thread until the signal aborts; a thread that comes later goes back to the pool. */
function untilAborted(taken, signal, giveBack) {
  if (!signal) return taken;
  return new Promise((resolve, reject) => {
    const abort = () => {
      reject(signal.reason);
      taken.then((thread) => thread && giveBack(thread), () => {});
    };
    signal.addEventListener('abort', abort, { once: true });
    taken.then(resolve, reject).finally(() => signal.removeEventListener('abort', abort));
  });
}

/** Runs a message in a worker, which is terminated if the run is aborted or fails. */
function runInThread(pool, thread, message, progress, signal) {
  if (signal?.aborted) {
    pool.giveBack(thread);
    return Promise.reject(signal.reason);
  }
  return new Promise((resolve, reject) => {
    const abort = () => settle(() => reject(signal.reason), pool.lose);
    const settle = (result, leave) => {
      signal?.removeEventListener('abort', abort);
      thread.onMessage = thread.onError = () => {};
      leave(thread);
      result();
    };
    const fail = (error) => settle(() => reject(error), pool.lose);
    thread.onError = (error) => fail(new NeuralMeshError(trapLine(error)));
    thread.onMessage = (event) => {
      if (event.answer) return settle(() => resolve(event.answer), pool.giveBack);
      if (event.failed) return fail(new NeuralMeshError(event.failed));
      try {
        progress?.(...event.progress);
      } catch (error) {
        fail(error);
      }
    };
    signal?.addEventListener('abort', abort, { once: true });
    thread.hold();
    thread.post({ request: message }, [message.buffer]);
  });
}

/** Runs a message in this thread; an abort takes effect at the next call of `progress`. */
async function runHere(module, message, progress, signal) {
  const { imports, run } = makeRunner();
  const instance = await WebAssembly.instantiate(module, imports);
  signal?.throwIfAborted();
  const listener = (share, part) => {
    progress?.(share, part);
    return signal?.aborted ?? false;
  };
  const answer = run(instance, message, listener);
  signal?.throwIfAborted();
  return answer;
}

/** Unpacks an answer, or throws its error. */
function readAnswer(answer) {
  const { json, array } = unpackMessage(answer);
  // Successful calls of the simplifier have a number by this name.
  if (typeof json.error === 'string') {
    throw new NeuralMeshError(json.error);
  }
  return { json, array };
}

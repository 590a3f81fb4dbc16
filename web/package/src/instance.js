// One instance of a WebAssembly module and a request to it. Runs in the page and in workers alike; knows neither.

import { NeuralMeshError } from './error.js';

/**
 * Makes the imports of an instance and a function that runs requests in it, one after the other.
 *
 * @returns {{imports: object, run: (instance: WebAssembly.Instance, request: Uint8Array, listener: Function) => Uint8Array}} `run` returns
 *   the answer; it stops the program where `listener(share, part)` returns true, and throws what the listener throws
 */
export function makeRunner() {
  let listen = null;
  let thrown = null;
  // An exception cannot cross the frames of WebAssembly without leaving them half free_messages, so that the run ends first.
  const progress = (share, part) => {
    try {
      return listen(share, part >>> 0) ? 1 : 0;
    } catch (error) {
      thrown = { error };
      return 1;
    }
  };
  const run = (instance, request, listener) => {
    [listen, thrown] = [listener, null];
    const answer = answerOrLine(instance.exports, request);
    if (thrown) throw thrown.error;
    return answer;
  };
  return { imports: { env: { progress, now: () => performance.now() } }, run };
}

/** Copies the request in and the answer out. Addresses arrive as signed numbers; views are made after each call, as memory grows. */
function answerTo({ memory, allocate_request, answer, answer_length, free_messages }, request) {
  const from = allocate_request(request.length) >>> 0;
  if (from === 0) throw new NeuralMeshError(`no memory for a request of ${request.length} bytes`);
  new Uint8Array(memory.buffer, from, request.length).set(request);
  const to = answer(request.length) >>> 0;
  const bytes = new Uint8Array(memory.buffer, to, answer_length() >>> 0).slice();
  free_messages();
  return bytes;
}

/** Turns a trap, behind which the instance is unusable, into an error with one line. */
function answerOrLine(exports, request) {
  try {
    return answerTo(exports, request);
  } catch (error) {
    // Engines say RangeError where the stack or the address space is full.
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) throw new NeuralMeshError(trapLine(error));
    throw error;
  }
}

/** The line for a program that ended in the middle. */
export function trapLine({ message }) {
  return `the program failed: ${message}: use a smaller mesh if memory is short, or report the error`;
}

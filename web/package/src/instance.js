// Runs a request in an instance of a WebAssembly module, in a page or a worker.

import { NeuralMeshError } from './error.js';

/**
 * Creates the imports of an instance and a function that runs requests in it, one after the other.
 *
 * @returns {{imports: object, run: (instance: WebAssembly.Instance, request: Uint8Array | object, listener: Function) => Uint8Array}} `run` returns
 *   the answer; it stops the program where `listener(share, part)` returns true, and throws what the listener throws
 */
export function makeRunner() {
  let listen = null;
  let thrown = null;
  // An exception must not unwind WebAssembly frames, which would corrupt the instance, so it is thrown after the run.
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

/** Copies the request, packed or planned, in and the answer out. Addresses arrive as signed numbers, and views are renewed after each call, as memory grows. */
function answerTo({ memory, allocate_request, answer, answer_length, free_messages }, request) {
  const { nBytes, write } = request instanceof Uint8Array ? { nBytes: request.length, write: (to) => to.set(request) } : request;
  const from = allocate_request(nBytes) >>> 0;
  if (from === 0) throw new NeuralMeshError(`no memory for a request of ${nBytes} bytes`);
  write(new Uint8Array(memory.buffer, from, nBytes));
  const to = answer(nBytes) >>> 0;
  const bytes = new Uint8Array(memory.buffer, to, answer_length() >>> 0).slice();
  free_messages();
  return bytes;
}

/** Returns the answer, or throws a one-line error for a trap, after which the instance is unusable. */
function answerOrLine(exports, request) {
  try {
    return answerTo(exports, request);
  } catch (error) {
    // Engines throw RangeError if the stack or the address space is full.
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) throw new NeuralMeshError(trapLine(error));
    throw error;
  }
}

/** Returns the error message for a program that crashed. */
export function trapLine({ message }) {
  return `the program failed: ${message}: use a smaller mesh if memory is short, or report the error`;
}

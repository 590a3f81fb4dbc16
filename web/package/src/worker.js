// Runs in a worker: receives a compiled module, then requests, and posts progress and answers. The build puts its text into the package.

import { makeRunner } from './instance.js';

/** Milliseconds between two progress messages, about two frames of a display. */
const PROGRESS_EVERY = 30;

let module = null;

/** Runs one request and posts its answer. Each request has a new instance, so its memory is freed; that takes one or two milliseconds. */
function onRequest(request, post) {
  let last = -Infinity;
  let lastPart = -1;
  const progress = (share, part) => {
    const now = performance.now();
    if (part === lastPart && now - last < PROGRESS_EVERY) return false;
    [last, lastPart] = [now, part];
    post({ progress: [share, part] });
    return false;
  };
  try {
    const { imports, run } = makeRunner();
    const answer = run(new WebAssembly.Instance(module, imports), request, progress);
    post({ answer }, [answer.buffer]);
  } catch (error) {
    post({ failed: error.message });
  }
}

function listen(post) {
  return (message) => {
    if (message.request) return onRequest(message.request, post);
    module = message.module;
    post({ ready: true });
  };
}

// `require` exists in Node, Deno and Bun, but not in a browser.
if (typeof require === 'function') {
  const { parentPort } = require('node:worker_threads');
  parentPort.on('message', listen((message, moved) => parentPort.postMessage(message, moved)));
} else {
  const hear = listen((message, moved) => self.postMessage(message, moved));
  self.onmessage = ({ data }) => hear(data);
}

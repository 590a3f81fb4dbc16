// Splits long loops into short slices, so that the page stays responsive without threads.

/** Milliseconds after which a loop yields to the page. */
const PATIENCE = 8;

let began = performance.now();

const pause = globalThis.scheduler?.yield
  ? () => globalThis.scheduler.yield()
  : () => new Promise((resolve) => setTimeout(resolve));

/** Yields to the page if the last time is long ago. */
export async function breathe() {
  if (performance.now() - began < PATIENCE) return;
  await pause();
  began = performance.now();
}

/** Calls `work(from, to)` over slices of 0 to n, with breaks between them. */
export async function inSlices(n, work) {
  const size = 1 << 15;
  for (let from = 0; from < n; from += size) {
    work(from, Math.min(n, from + size));
    await breathe();
  }
}

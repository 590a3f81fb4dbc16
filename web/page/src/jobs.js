// Jobs one at a time, the most urgent first: a more urgent one puts the one that runs back into the queue.

/** Makes a queue; `changed(job)` hears which job runs, null where none does, and how much of it is done as `job.share`. */
export function makeJobs(changed) {
  return { waiting: [], running: null, changed };
}

/**
 * Asks for a job {owner, key, title, urgency, run}; 0 is the most urgent. `run({signal, progress})` does it, from the start where it was
 * put back. A job that waits already under the key of the same owner is that one, as urgent as the more urgent of the two.
 */
export function ask(jobs, { owner, key, title, urgency, run }) {
  const known = [jobs.running, ...jobs.waiting].find((job) => job?.owner === owner && job?.key === key && !isGivenUp(job));
  const job = known ?? makeJob({ owner, key, title, urgency, run });
  job.urgency = Math.min(job.urgency, urgency);
  if (!known) jobs.waiting.push(job);
  if (jobs.running && jobs.running.urgency > urgency) putBack(jobs.running);
  start(jobs);
  return job.promise;
}

function makeJob(job) {
  const promise = new Promise((resolve, reject) => { Object.assign(job, { resolve, reject, share: 0 }); });
  return Object.assign(job, { promise });
}

/** Gives up jobs that have not begun and that are not wanted any more. */
export function drop(jobs, isUnwanted) {
  const dropped = jobs.waiting.filter(isUnwanted);
  jobs.waiting = jobs.waiting.filter((job) => !dropped.includes(job));
  for (const job of dropped) job.reject(new DOMException('cancelled', 'AbortError'));
}

/** Ends what runs and gives up what waits, of the jobs that are meant. */
export function cancel(jobs, isMeant = () => true) {
  drop(jobs, isMeant);
  const { running } = jobs;
  if (!running || !isMeant(running)) return;
  running.isPutBack = false;
  running.controller.abort();
}

/** Whether a job still runs that nobody waits for. */
function isGivenUp({ controller, isPutBack }) {
  return Boolean(controller?.signal.aborted) && !isPutBack;
}

function putBack(job) {
  job.isPutBack = true;
  job.controller.abort();
}

async function start(jobs) {
  if (jobs.running || jobs.waiting.length === 0) return;
  const job = jobs.waiting.reduce((best, other) => (other.urgency < best.urgency ? other : best));
  jobs.waiting = jobs.waiting.filter((other) => other !== job);
  jobs.running = job;
  Object.assign(job, { controller: new AbortController(), isPutBack: false, share: 0 });
  jobs.changed(job);
  const progress = (share) => {
    job.share = share;
    if (jobs.running === job) jobs.changed(job);
  };
  const outcome = await settle(job, progress);
  jobs.running = null;
  if (outcome.isPutBack) jobs.waiting.unshift(job);
  else if (outcome.error) job.reject(outcome.error);
  else job.resolve(outcome.value);
  // What hears of the end may ask for the next job.
  await Promise.resolve();
  start(jobs);
  if (!jobs.running) jobs.changed(null);
}

async function settle(job, progress) {
  const { signal } = job.controller;
  try {
    const value = await job.run({ signal, progress });
    // What came too late is cancelled.
    signal.throwIfAborted();
    return { value };
  } catch (error) {
    return { error, isPutBack: job.isPutBack };
  }
}

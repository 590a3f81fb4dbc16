// Runs jobs one at a time, the most urgent first; a more urgent job puts the running one back into the queue.

/** Creates a queue; `changed(job)` is called with the running job, or null, whenever the job or its `share` changes. */
export function makeJobs(changed) {
  return { waiting: [], running: null, changed };
}

/**
 * Queues a job {owner, key, title, urgency, run} and returns its promise; urgency 0 is the most urgent.
 *
 * `run({signal, progress})` does the work, and is called again after the job was put back. A queued or running job with an equal owner and
 * key is reused, with the higher urgency of the two.
 */
export function ask(jobs, { owner, key, title, urgency, run }) {
  const known = [jobs.running, ...jobs.waiting].find((job) => job?.owner === owner && job?.key === key && !isCancelled(job));
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

/** Removes waiting jobs that are no longer wanted. */
export function drop(jobs, isUnwanted) {
  const dropped = jobs.waiting.filter(isUnwanted);
  jobs.waiting = jobs.waiting.filter((job) => !dropped.includes(job));
  for (const job of dropped) job.reject(new DOMException('cancelled', 'AbortError'));
}

/** Aborts the running job and removes waiting jobs, if they match. */
export function cancel(jobs, matches = () => true) {
  drop(jobs, matches);
  const { running } = jobs;
  if (!running || !matches(running)) return;
  running.isPutBack = false;
  running.controller.abort();
}

/** Returns whether a job is being aborted for good. */
function isCancelled({ controller, isPutBack }) {
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
  // Callers that wait for this job may queue another one first.
  await Promise.resolve();
  start(jobs);
  if (!jobs.running) jobs.changed(null);
}

async function settle(job, progress) {
  const { signal } = job.controller;
  try {
    const value = await job.run({ signal, progress });
    // A result after the abort is discarded.
    signal.throwIfAborted();
    return { value };
  } catch (error) {
    return { error, isPutBack: job.isPutBack };
  }
}

// Shows errors, the current work and its progress.

const at = (id) => document.getElementById(id);

/** Shows an error in one line; an empty string hides it. */
export function warn(words) {
  at('alert').textContent = words;
  at('alert').hidden = words === '';
}

/** Waits for work and shows its error, except for cancelled work; returns null on failure. */
export async function attempt(work) {
  try {
    return await work;
  } catch (error) {
    if (error?.name !== 'AbortError') warn(oneLine(error));
    return null;
  }
}

/** Returns the first line of an error's message. */
export function oneLine(error) {
  return String(error?.message || error).split('\n')[0];
}

/** Shows the running job and its progress, or the text `idle` without a job. */
export function showWork(job, idle) {
  const words = job?.title ?? idle;
  at('work').classList.toggle('idle', !job);
  at('cancel').disabled = !job;
  // Setting equal text would make screen readers repeat it.
  if (at('doing').textContent !== words) at('doing').textContent = words;
  const done = Math.round(100 * Math.min(job?.share ?? 0, 1));
  at('done').style.width = `${done}%`;
  // The progress of a job is unknown until it reports some.
  at('progress').classList.toggle('unknown', Boolean(job) && done === 0);
  if (done > 0) at('progress').ariaValueNow = String(done);
  else at('progress').removeAttribute('aria-valuenow');
  at('progress').ariaValueText = job ? `${job.title}: ${done > 0 ? `${done} %` : 'begun'}` : 'nothing to do';
}

// What the page says in words: what goes wrong, what is being done and how far it is.

const at = (id) => document.getElementById(id);

/** Says in one line what is wrong; nothing where there are no words. */
export function warn(words) {
  at('alert').textContent = words;
  at('alert').hidden = words === '';
}

/** Waits for work; what it fails with is said, but for what was given up. */
export async function attempt(work) {
  try {
    return await work;
  } catch (error) {
    if (error?.name !== 'AbortError') warn(oneLine(error));
    return null;
  }
}

/** Why something failed. */
export function oneLine(error) {
  return String(error?.message || error).split('\n')[0];
}

/** Shows the job that runs and how much of it is done; without one, what is to be said then. */
export function showWork(job, idle) {
  const words = job?.title ?? idle;
  at('work').classList.toggle('idle', !job);
  at('cancel').disabled = !job;
  // The same words again would be read aloud again.
  if (at('doing').textContent !== words) at('doing').textContent = words;
  const done = Math.round(100 * Math.min(job?.share ?? 0, 1));
  at('done').style.width = `${done}%`;
  // Nobody knows how far a job is that has said nothing yet.
  at('progress').classList.toggle('unknown', Boolean(job) && done === 0);
  if (done > 0) at('progress').ariaValueNow = String(done);
  else at('progress').removeAttribute('aria-valuenow');
  at('progress').ariaValueText = job ? `${job.title}: ${done > 0 ? `${done} %` : 'begun'}` : 'nothing to do';
}

// The session of an open mesh: its original, its results so far, and the order of jobs.
//
// Urgency of jobs: what the reader waits for, then distances shown as colours, then levels, then figures.

import { compareFiles, lookAtFile, simplifyFile } from './engine.js';
import { ask, cancel, drop } from './jobs.js';
import { paintPair } from './measured.js';
import { LEVELS, nameOfResult, wishOfShare } from './sizes.js';

export const NOW = 0;
export const COLOURS = 1;
const LEVEL = 2;
const FIGURES = 3;

/** Largest number of results kept: the levels under a few options, and some chosen sizes. */
const MOST_RESULTS = 24;

/** Creates the session of a file before its mesh is read; `ending` is the extension of its results. */
export function makeSession(file, ending) {
  return { file, ending, mesh: null, notes: [], results: new Map(), failed: new Map(), conversions: new Map() };
}

/** Reads the mesh of a session. */
export async function readSession(jobs, session) {
  const { file } = session;
  const run = (control) => lookAtFile(file, control);
  const { mesh, notes } = await ask(jobs, { owner: session, key: 'look', title: `Reading ${file.name}`, urgency: NOW, run });
  if (mesh.faces.length === 0) throw new Error(`${file.name} has no faces: there is nothing to simplify`);
  Object.assign(session, { mesh, notes });
}

/** Cancels a wish that the reader no longer waits for. */
export function forget(jobs, key) {
  cancel(jobs, (job) => job.key === key && job.urgency === NOW);
}

/** Returns the result of a wish, and makes it first if needed. */
export function resultOf(jobs, session, wish, urgency) {
  const known = session.results.get(wish.key);
  if (known) return Promise.resolve(known);
  const run = (control) => makeResult(session, wish, control);
  return ask(jobs, { owner: session, key: wish.key, title: `Making ${wish.title}`, urgency, run });
}

async function makeResult(session, wish, control) {
  const { file, ending } = session;
  const options = { ...wish.size, ...wish.options, no_check: true };
  const made = await simplifyFile(file, options, nameOfResult(file.name, wish, ending), control);
  const { mesh } = await lookAtFile(made.file, control);
  const result = { ...made, wish, mesh, comparison: null, scale: null, shares: null };
  session.results.set(wish.key, result);
  session.failed.delete(wish.key);
  return result;
}

/** Makes the missing levels under these options in the background, calls `made` for each, and drops other queued levels. */
export function prepareLevels(jobs, session, options, made) {
  const wishes = LEVELS.map((share) => wishOfShare(share, options));
  drop(jobs, ({ key, urgency }) => urgency === LEVEL && wishes.every((wish) => wish.key !== key));
  for (const wish of wishes) {
    if (session.results.has(wish.key)) continue;
    resultOf(jobs, session, wish, LEVEL).then(made, (error) => {
      // Cancelled levels can be made later; failed ones are marked at their buttons.
      if (error.name !== 'AbortError') session.failed.set(wish.key, error.message);
      made();
    });
  }
}

/** Measures a result, once, and drops queued measurements of other results. */
export async function measure(jobs, session, result, urgency = FIGURES) {
  if (result.comparison) return;
  const key = `compare ${result.wish.key}`;
  drop(jobs, (job) => job.key.startsWith('compare ') && job.key !== key);
  const run = (control) => compareFiles(session.file, result.file, control);
  const measured = await ask(jobs, { owner: session, key, title: `Measuring ${result.wish.title}`, urgency, run });
  const origins = [session.mesh, result.mesh].map(({ origin }) => origin);
  Object.assign(result, await paintPair(measured, origins, session.place), { comparison: measured.comparison });
}

/** Removes and returns the oldest results if there are too many. */
export function outdatedResults({ results, shown }) {
  const outdated = [...results.values()].filter((result) => result !== shown).slice(0, Math.max(results.size - MOST_RESULTS, 0));
  for (const { wish } of outdated) results.delete(wish.key);
  return outdated;
}

/** Returns a result in another format by simplifying again with equal options. */
export function convert(jobs, session, { wish, file }, ending) {
  if (ending === session.ending) return Promise.resolve(file);
  const name = nameOfResult(session.file.name, wish, ending);
  const key = `convert ${ending} ${wish.key}`;
  const known = session.conversions.get(key);
  if (known) return Promise.resolve(known);
  const run = async (control) => {
    const made = await simplifyFile(session.file, { ...wish.size, ...wish.options, no_check: true }, name, control);
    session.conversions.set(key, made.file);
    return made.file;
  };
  return ask(jobs, { owner: session, key, title: `Writing ${name}`, urgency: NOW, run });
}

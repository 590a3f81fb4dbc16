// The mesh that is open: its original, the results made of it so far, and which job comes next.
//
// Urgency of jobs: what the reader waits for, then distances that are to be seen as colours, then levels, then figures.

import { compareFiles, lookAtFile, simplifyFile } from './engine.js';
import { ask, cancel, drop } from './jobs.js';
import { paintPair } from './measured.js';
import { LEVELS, nameOfResult, wishOfShare } from './sizes.js';

export const NOW = 0;
export const COLOURS = 1;
const LEVEL = 2;
const FIGURES = 3;

/** Results that are kept: the levels under a few options, and some sizes that were looked at. */
const MOST_RESULTS = 24;

/** Makes the session of a file, whose mesh is not read yet; `ending` is that of its results. */
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

/** Gives up a wish that the reader does not wait for any more. */
export function forget(jobs, key) {
  cancel(jobs, (job) => job.key === key && job.urgency === NOW);
}

/** The result of a wish, made where it is not there yet. */
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

/** Makes the levels that are missing under these options, in the background; `made` hears of each. Others are not wanted any more. */
export function prepareLevels(jobs, session, options, made) {
  const wishes = LEVELS.map((share) => wishOfShare(share, options));
  drop(jobs, ({ key, urgency }) => urgency === LEVEL && wishes.every((wish) => wish.key !== key));
  for (const wish of wishes) {
    if (session.results.has(wish.key)) continue;
    resultOf(jobs, session, wish, LEVEL).then(made, (error) => {
      // What was given up can be made later; what failed shows at its button.
      if (error.name !== 'AbortError') session.failed.set(wish.key, error.message);
      made();
    });
  }
}

/** Measures a result, once. Other results that wait for that are shown no more. */
export async function measure(jobs, session, result, urgency = FIGURES) {
  if (result.comparison) return;
  const key = `compare ${result.wish.key}`;
  drop(jobs, (job) => job.key.startsWith('compare ') && job.key !== key);
  const run = (control) => compareFiles(session.file, result.file, control);
  const measured = await ask(jobs, { owner: session, key, title: `Measuring ${result.wish.title}`, urgency, run });
  const origins = [session.mesh, result.mesh].map(({ origin }) => origin);
  Object.assign(result, await paintPair(measured, origins, session.place), { comparison: measured.comparison });
}

/** Takes the oldest results out where there are too many, and gives them back. */
export function outdatedResults({ results, shown }) {
  const outdated = [...results.values()].filter((result) => result !== shown).slice(0, Math.max(results.size - MOST_RESULTS, 0));
  for (const { wish } of outdated) results.delete(wish.key);
  return outdated;
}

/** A result in another format: simplified once more, the same way. */
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

// What the reader wants: the size in one of three ways, the options, and the words and names that follow from them.

import { count } from '../../../cli/viewer/src/words.js';
import { stemOf } from './files.js';

/** Shares of the vertices that are made in the background; the first one is made at once. */
export const LEVELS = [0.1, 0.5, 0.25, 0.05, 0.02];

/** The ends of the slider. */
const [LEAST, MOST] = [0.002, 1];

const SWITCHES = ['keep_features', 'lock_boundaries', 'subset'];
const CHOICES = { optimize: 'balanced', effort: 'standard' };

const at = (id) => document.getElementById(id);

/** The share that a place of the slider stands for, of two digits. */
export function shareAt(place) {
  const share = LEAST * (MOST / LEAST) ** place;
  const near = LEVELS.find((level) => Math.abs(placeOfShare(level) - place) < 0.004);
  return near ?? Number(share.toPrecision(2));
}

/** The place of the slider that stands for a share. */
export function placeOfShare(share) {
  return Math.log(share / LEAST) / Math.log(MOST / LEAST);
}

/** A share in percent, as people say it. */
export function percent(share) {
  return `${Number((100 * share).toPrecision(3))} %`;
}

/** The options that differ from what the program does without them. */
export function readOptions() {
  const chosen = Object.entries(CHOICES).filter(([id, usual]) => at(id).value !== usual).map(([id]) => [id, at(id).value]);
  const switched = SWITCHES.filter((id) => at(id).checked).map((id) => [id, true]);
  return Object.fromEntries([...chosen, ...switched]);
}

/** What is wanted now, or why that is no size: `{wish}` or `{why}`. */
export function readWish() {
  const options = readOptions();
  const number = (id) => at(id).valueAsNumber;
  if (at('by').value === 'ratio') return { wish: wishOfShare(shareAt(number('share')), options) };
  if (at('by').value === 'faces') {
    const faces = Math.round(number('faces'));
    return faces >= 1 ? { wish: makeWish({ faces }, `${count(faces)} faces`, `${faces}-faces`, options) } : { why: 'Give a number of faces.' };
  }
  const error = number('error');
  if (!(error > 0)) return { why: 'Give a distance above 0 %.' };
  return { wish: makeWish({ error: `${error}%` }, `within ${error} %`, `within-${error}`, options) };
}

/** A share of the vertices under options. */
export function wishOfShare(share, options) {
  return makeWish({ ratio: share }, percent(share), percent(share).replace(' %', ''), options);
}

function makeWish(size, title, suffix, options) {
  return { size, options, title, suffix, key: JSON.stringify([size, options]) };
}

/** The name of the file that a wish becomes. */
export function nameOfResult(name, { suffix }, ending) {
  return `${stemOf(name)}-${suffix}.${ending}`;
}

// Tables of the methods: medians, means and quotients, and the missing results.

import { fillSorted } from './sorted.js';
import { number, precise, spoken } from './words.js';

/** Statistics of a cell, with their names. */
export const STATISTICS = {
  median: () => 'median',
  mean: () => 'mean',
  quotient: (other) => `quotient to ${other}`,
};

const DIGITS = 3;

const at = (id) => document.getElementById(id);

/** Creates a table cell; a small number gives the number of results if some have no value. */
function cellOf(standing, column, statistic) {
  const { n, n_quotients: nQuotients, ...values } = standing.cells[column];
  const [value, some, all] = statistic === 'quotient' ? [values.quotient, nQuotients, standing.both] : [values[statistic], n, standing.results];
  if (value === null) return { value, text: '' };
  // Decimals from even numbers of meshes mean nothing in numbers of thousands.
  const text = statistic === 'quotient' ? precise(value, DIGITS) : number(Math.abs(value) < 1000 ? value : Math.round(value), DIGITS);
  return { value, text, small: some < all ? `of ${some}` : '' };
}

/** Fills the table of one figure at every ratio, with all statistics. */
export function fillSingle({ columns, methods, ratios, standings, relative_to: other }, { column, ratio }) {
  const { name, unit, about } = columns[column];
  at('title-one').textContent = spoken(name);
  at('about').textContent = `${about[0].toUpperCase()}${about.slice(1)}${unit ? `, in ${unit}` : ''}.`;
  const ways = Object.keys(STATISTICS).filter((way) => way !== 'quotient' || other);
  const ofRatios = ratios.flatMap((share, i) => ways.map((way) => (
    { title: `${share} ${way === 'quotient' ? `/ ${other}` : way}`, isChosen: i === ratio })));
  const rows = methods.map((method, m) => [
    { value: method, text: method },
    ...ratios.flatMap((_, r) => ways.map((way) => cellOf(standings[r][m], column, way))),
  ]);
  fillSorted(at('one'), [{ title: 'method', isWord: true }, ...ofRatios], rows, 1 + ratio * ways.length);
}

/** Fills the table of all figures at one ratio, with one statistic. */
export function fillOverall({ columns, methods, ratios, standings, relative_to: other }, { column, ratio, statistic }) {
  at('title-all').textContent = `All figures at ratio ${ratios[ratio]}: ${STATISTICS[statistic](other)}`;
  const heads = columns.map(({ name, unit, about }, i) => (
    { title: spoken(name), unit: statistic === 'quotient' ? '' : unit, about, isChosen: i === column }));
  const hasFailed = standings.flat().some(({ cases, results }) => results < cases);
  const failed = ({ cases, results }) => ({ value: cases - results, text: number(cases - results), small: results < cases ? `of ${cases}` : '' });
  const rows = methods.map((method, m) => [
    { value: method, text: method },
    ...(hasFailed ? [failed(standings[ratio][m])] : []),
    ...columns.map((_, i) => cellOf(standings[ratio][m], i, statistic)),
  ]);
  const ofFailed = hasFailed ? [{ title: 'failed', about: 'cases without a result' }] : [];
  fillSorted(at('all'), [{ title: 'method', isWord: true }, ...ofFailed, ...heads], rows);
}

/** Lists the missing results with reasons; hidden if there are none. */
export function fillFailures({ failures }, nMore) {
  at('how-failures').textContent = nMore > 0 ? `The first ${failures.length} reasons; tables.md has ${number(nMore)} more.` : '';
  at('failures-section').hidden = failures.length === 0;
  const rows = failures.map(({ method, cases, first, why }) => [
    { value: method, text: method }, { value: cases, text: number(cases) }, { value: first, text: first }, { value: why, text: why },
  ]);
  const columns = [{ title: 'method', isWord: true }, { title: 'cases' }, { title: 'first case', isWord: true }, { title: 'why', isWord: true }];
  fillSorted(at('failures'), columns, rows);
}

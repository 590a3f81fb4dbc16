// The table of figures next to the view: a row per figure, a column per result, the best value of each row marked.

import { element } from './element.js';
import { bestColumns, TOLD, tell } from './verdicts.js';
import { number, spoken } from './words.js';

/**
 * Fills a table with the figures of a comparison: those that are said in words, with verdicts, and all others in a second body, which a
 * button shows. With `hasAll` there is a row for each figure in words, also without a value, but for FLIP.
 */
export function fillTable(table, comparison, { hasAll = false } = {}) {
  const { figures, results } = comparison;
  const valuesOf = (name) => results.map(({ bytes, values }) => (name === 'bytes' ? bytes : values[name]));
  const isKnown = (name) => valuesOf(name).some((value) => value !== null && value !== undefined);
  const abouts = Object.fromEntries(figures.map(({ name, about }) => [name, about]));
  table.createTHead().append(row('th', ['', ...results.map(({ name }) => name)], { scope: 'col' }));
  const body = table.createTBody();
  const isTold = (name) => (hasAll && name !== 'flip') || isKnown(name);
  for (const name of TOLD.filter(isTold)) body.append(toldRow(name, valuesOf(name), comparison, abouts[name]));
  const others = figures.filter(({ name }) => !TOLD.includes(name) && isKnown(name));
  if (others.length === 0) return;
  const more = table.createTBody();
  more.hidden = true;
  for (const figure of others) more.append(plainRow(figure, valuesOf(figure.name)));
  table.createTFoot().append(moreRow(more, others.length, results.length));
}

/** Returns the row of a figure in words; each cell has its verdict, and the heading that of the shown column. */
function toldRow(name, values, comparison, about = '') {
  const told = values.map((value) => tell(name, value, comparison));
  const line = row('td', told.map(({ value }) => value));
  const head = element('th', told[0].title, { scope: 'row', title: about });
  head.append(element('span', '', { className: 'verdict' }));
  told.forEach(({ grade, words }, at) => {
    Object.assign(line.cells[at], { className: grade, title: words });
    Object.assign(line.cells[at].dataset, { words });
  });
  markBest(line, bestColumns(name, values));
  line.prepend(head);
  return line;
}

function plainRow({ name, unit, about }, values) {
  const line = row('td', values.map((value) => number(value)));
  const head = element('th', spoken(name), { scope: 'row', title: about });
  if (!spoken(name).endsWith(unit)) head.append(' ', element('span', unit, { className: 'unit' }));
  markBest(line, bestColumns(name, values));
  line.prepend(head);
  return line;
}

function markBest(line, columns) {
  for (const at of columns) {
    line.cells[at].classList.add('best');
    line.cells[at].append(element('span', ' best', { className: 'unseen' }));
  }
}

function moreRow(body, n, nResults) {
  const words = () => (body.hidden ? `${n} more figures` : 'Fewer figures');
  const button = element('button', words(), { type: 'button', ariaExpanded: 'false' });
  button.addEventListener('click', () => {
    body.hidden = !body.hidden;
    Object.assign(button, { textContent: words(), ariaExpanded: String(!body.hidden) });
  });
  const line = document.createElement('tr');
  const cell = element('td', '', { colSpan: nResults + 1 });
  cell.append(button);
  line.append(cell);
  return line;
}

/** Marks the column of the result that is shown, and says its verdicts. */
export function showColumn(table, shown) {
  for (const line of [...table.tHead.rows, ...[...table.tBodies].flatMap((body) => [...body.rows])]) {
    for (let i = 1; i < line.cells.length; i++) line.cells[i].classList.toggle('shown', i === shown + 1);
    const verdict = line.cells[0].querySelector('.verdict');
    const cell = line.cells[shown + 1];
    if (!verdict) continue;
    verdict.textContent = cell.dataset.words;
    verdict.className = `verdict ${['good', 'fair', 'poor', 'none'].find((grade) => cell.classList.contains(grade))}`;
  }
  scrollTo(table.parentElement, table.tHead.rows[0].cells);
}

/** Scrolls only the table sideways until the marked column is next to the first one. */
function scrollTo(box, cells) {
  const cell = [...cells].find((one) => one.classList.contains('shown'));
  const [left, right] = [cell.offsetLeft - cells[0].offsetWidth, cell.offsetLeft + cell.offsetWidth - box.clientWidth];
  box.scrollLeft = Math.min(Math.max(box.scrollLeft, right), left);
}

/** Fills a list with the meanings of the figures. */
export function fillMeanings(list, figures) {
  for (const { name, unit, about } of figures) {
    list.append(element('dt', spoken(name)), element('dd', unit ? `${about} (${unit})` : about));
  }
}

function row(tag, texts, properties = {}) {
  const line = document.createElement('tr');
  line.append(...texts.map((text) => element(tag, text, { ...properties, title: text })));
  return line;
}

// The table of numbers next to the view: a row per figure, a column per result.

import { element } from './element.js';
import { number, spoken } from './words.js';

/** Fills a table element with the figures of a comparison. */
export function fillTable(table, { figures, results }) {
  const head = row('th', ['Figure', ...results.map((result) => result.name)], 'col');
  table.createTHead().append(head);
  const body = table.createTBody();
  for (const { name, unit, about } of figures) {
    const values = results.map((result) => number(result.values[name]));
    body.append(named(spoken(name), unit, about, values));
  }
}

/** Marks the column of the result that is shown. */
export function showColumn(table, shown) {
  for (const { cells } of table.rows) {
    for (let i = 1; i < cells.length; i++) cells[i].classList.toggle('shown', i === shown + 1);
  }
  scrollTo(table.parentElement, table.tHead.rows[0].cells);
}

/** Scrolls only the table sideways until the marked column is next to the first one. */
function scrollTo(box, cells) {
  const cell = [...cells].find((cell) => cell.classList.contains('shown'));
  const [left, right] = [cell.offsetLeft - cells[0].offsetWidth, cell.offsetLeft + cell.offsetWidth - box.clientWidth];
  box.scrollLeft = Math.min(Math.max(box.scrollLeft, right), left);
}

/** Fills a list with the meanings of the figures. */
export function fillMeanings(list, figures) {
  for (const { name, unit, about } of figures) {
    list.append(element('dt', spoken(name)), element('dd', unit ? `${about} (${unit})` : about));
  }
}

function named(name, unit, about, values) {
  const line = row('td', values);
  const head = element('th', name, { scope: 'row', title: about });
  if (!name.endsWith(unit)) head.append(' ', element('span', unit, { className: 'unit' }));
  line.prepend(head);
  return line;
}

function row(tag, texts, scope) {
  const line = document.createElement('tr');
  line.append(...texts.map((text) => element(tag, text, { ...(scope && { scope }), title: text })));
  return line;
}

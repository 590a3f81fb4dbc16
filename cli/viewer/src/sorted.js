// Tables that sort by the column whose head is clicked: numbers from the smallest, again from the largest, empty cells last.

import { element } from './element.js';

/**
 * Fills a table. `columns` are {title, unit, about, isWord, isChosen}; `rows` are lists of {value, text, small, element}. It is
 * sorted as the reader chose before, else by column `first`.
 */
export function fillSorted(table, columns, rows, first = null) {
  const titles = columns.map(({ title }) => title).join('\n');
  // The choice is kept only for a table with equal columns.
  if (table.sorted?.titles !== titles) table.sorted = { titles, by: first, isDown: false };
  const head = document.createElement('thead');
  head.append(headRow(columns, table.sorted, (by) => {
    const { sorted } = table;
    table.sorted = { titles, by, isDown: sorted.by === by && !sorted.isDown };
    fillSorted(table, columns, rows);
    table.tHead.rows[0].cells[by].querySelector('button').focus();
  }));
  const body = document.createElement('tbody');
  body.append(...inOrder(rows, table.sorted).map((row) => bodyRow(columns, row)));
  table.replaceChildren(head, body);
}

function inOrder(rows, { by, isDown }) {
  if (by === null) return rows;
  const sign = isDown ? -1 : 1;
  const compare = ({ value: a }, { value: b }) => {
    const [isNoA, isNoB] = [a, b].map((value) => value === null || value === undefined || Number.isNaN(value));
    if (isNoA || isNoB) return isNoA - isNoB;
    return sign * (typeof a === 'string' ? a.localeCompare(b, 'en', { numeric: true }) : a - b);
  };
  return [...rows].sort((a, b) => compare(a[by], b[by]));
}

function headRow(columns, { by, isDown }, sort) {
  const row = document.createElement('tr');
  columns.forEach(({ title, unit, about, isWord, isChosen }, i) => {
    const cell = element('th', '', { scope: 'col', className: classes(isWord, isChosen) });
    const button = element('button', title, { type: 'button', title: about ?? '', className: 'sort' });
    if (unit) button.append(' ', element('span', unit, { className: 'unit' }));
    if (i === by) cell.ariaSort = isDown ? 'descending' : 'ascending';
    button.addEventListener('click', () => sort(i));
    cell.append(button);
    row.append(cell);
  });
  return row;
}

function bodyRow(columns, cells) {
  const row = document.createElement('tr');
  cells.forEach(({ text, small, element: own, title }, i) => {
    const cell = element(i === 0 ? 'th' : 'td', text ?? '', { className: classes(columns[i].isWord, columns[i].isChosen), title: title ?? '' });
    if (i === 0) cell.scope = 'row';
    if (own) cell.append(own);
    if (small) cell.append(' ', element('small', small));
    row.append(cell);
  });
  return row;
}

function classes(isWord, isChosen) {
  return `${isWord ? 'word' : ''} ${isChosen ? 'shown' : ''}`.trim();
}

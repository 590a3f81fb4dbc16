// The words over a pane: whose mesh it is, how large, and how many of its edges are marked; where textures are shown, whether it has one.

import { count } from './words.js';

const KINDS = ['open', 'non-manifold', 'turned'];

/** Fills the caption of a pane; `marked` is left out where the marked edges are not known. */
export function fillCaption(pane, role, { name, faces }, marked, ofCover) {
  const title = make('strong', role);
  const size = [make('div', name, 'name'), make('div', `${count(faces)} faces`)];
  const lines = [...size, ...(marked ? [marks(marked)] : []), make('div', ofCover, 'of-cover')];
  pane.querySelector('.caption').replaceChildren(title, ...lines);
}

function marks(marked) {
  const line = make('div', '', 'marks');
  marked.forEach((n, kind) => {
    if (n > 0) line.append(make('span', `${count(n)} ${KINDS[kind]}`, `mark mark-${kind}`));
  });
  if (marked.every((n) => n === 0)) line.textContent = 'closed, no marked edge';
  return line;
}

function make(tag, textContent, className = '') {
  return Object.assign(document.createElement(tag), { textContent, className, title: className === 'name' ? textContent : '' });
}

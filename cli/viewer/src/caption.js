// The caption over a pane: the mesh, its size, its number of marked edges, and whether it has a texture if textures are shown.

import { count } from './words.js';

const KINDS = ['open', 'non-manifold', 'turned'];

/** Fills the caption of a pane; without `marked` the marked edges are not mentioned. */
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

// The panel next to the view: buttons for levels and downloads, figures, recipes, notes.

import { element } from '../../../cli/viewer/src/element.js';
import { fillMeanings, fillTable, showColumn } from '../../../cli/viewer/src/table.js';
import { spoken } from '../../../cli/viewer/src/words.js';
import { recipesOf } from './recipes.js';
import { attempt, oneLine } from './status.js';
import { LEVELS, percent, wishOfShare } from './sizes.js';
import { copy, spokenSize } from './save.js';

/** Figures of the table, as in the program's own. */
const FIRST = [
  'vertices', 'faces', 'distance_mean', 'distance_max', 'normal_angle', 'boundary_edges', 'non_manifold_edges',
  'self_intersecting_faces', 'components_added', 'volume_change',
];

const at = (id) => document.getElementById(id);

/** Creates a button for each level, the finest last; `choose(share)` is called on a click. */
export function makeLevels(choose) {
  for (const share of [...LEVELS].sort((a, b) => a - b)) {
    const button = element('button', percent(share), { type: 'button' });
    button.dataset.share = share;
    button.addEventListener('click', () => choose(share));
    at('levels').append(button);
  }
}

/** Marks the levels that exist under these options, and the one that is shown. */
export function showLevels({ results, failed, shown }, options) {
  for (const button of at('levels').children) {
    const { key } = wishOfShare(Number(button.dataset.share), options);
    button.ariaPressed = String(shown?.wish.key === key);
    button.dataset.state = stateOf(key, results, failed);
    button.title = failed.get(key) ?? (results.has(key) ? 'ready' : 'not made yet');
  }
}

function stateOf(key, results, failed) {
  if (results.has(key)) return 'ready';
  return failed.has(key) ? 'failed' : 'missing';
}

/** Creates a button for each format; `choose(ending)` is called on a click. */
export function makeDownloads(endings, choose) {
  at('downloads').replaceChildren(...endings.map((ending) => {
    const button = element('button', ending.toUpperCase(), { type: 'button', title: `Download as ${ending.toUpperCase()}` });
    button.dataset.ending = ending;
    button.addEventListener('click', () => choose(ending));
    return button;
  }));
}

/** Shows the file size on the button of the format that exists already. */
export function showDownloads({ ending: ready, shown }) {
  for (const button of at('downloads').children) {
    const { ending } = button.dataset;
    const size = ending === ready && shown ? ` ${spokenSize(shown.file)}` : '';
    button.replaceChildren(ending.toUpperCase(), element('span', size, { className: 'unit' }));
    button.classList.toggle('main', ending === ready);
    button.disabled = !shown;
  }
}

/** Fills the table with the results under the present options that have been measured, the finest first. */
export function showFigures({ results, shown }, options) {
  const isListed = ({ comparison, wish }) => comparison && JSON.stringify(wish.options) === JSON.stringify(options);
  const measured = [...results.values()].filter(isListed).sort((a, b) => b.mesh.faces.length - a.mesh.faces.length);
  at('no-figures').hidden = measured.length > 0;
  at('figures').replaceChildren();
  if (measured.length === 0) return;
  const figures = measured[0].comparison.figures.filter(({ name }) => FIRST.includes(name));
  fillTable(at('figures'), { figures, results: measured.map(({ wish, comparison }) => ({ ...comparison.results[0], name: wish.title })) });
  if (measured.includes(shown)) showColumn(at('figures'), measured.indexOf(shown));
  if (at('meanings').children.length === 0) fillMeanings(at('meanings'), figures);
}

/** Marks the options that differ from the defaults. */
export function showChosen(options) {
  at('chosen').textContent = Object.entries(options).map(([name, value]) => spoken(value === true ? name : value)).join(', ');
}

/** Shows recipes that repeat the result outside the page. */
export function showRecipes({ file, shown }) {
  at('languages').replaceChildren(...recipesOf(file, shown.wish, shown.file.name).map(recipe));
}

function recipe({ title, text }) {
  const box = element('div', '', { className: 'recipe' });
  const button = element('button', 'Copy', { type: 'button', ariaLabel: `Copy: ${title}` });
  button.addEventListener('click', () => attempt(copy(text).then(() => { button.textContent = 'Copied'; })));
  const code = element('pre', '', { tabIndex: 0, ariaLabel: title });
  code.setAttribute('role', 'region');
  code.append(element('code', text));
  box.append(element('h3', title), button, code);
  return box;
}

/** Lists the notes about the mesh and the shown result. */
export function showNotes({ notes, shown }) {
  const { outcome = '', free = [] } = shown?.report ?? {};
  const stopped = outcome.startsWith('stopped') ? [outcome, ...free] : [];
  const lines = [...new Set([...stopped, ...notes, ...(shown?.notes ?? [])].map((note) => oneLine(note)))];
  at('notes').replaceChildren(...lines.map((line) => element('span', line)));
}

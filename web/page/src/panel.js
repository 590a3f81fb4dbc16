// The panel next to the view: buttons for levels and downloads, figures, recipes, notes.

import { element } from '../../../cli/viewer/src/element.js';
import { percentOff, spokenBytes } from '../../../cli/viewer/src/verdicts.js';
import { fillMeanings, fillTable, showColumn } from '../../../cli/viewer/src/table.js';
import { count, spoken } from '../../../cli/viewer/src/words.js';
import { recipesOf } from './recipes.js';
import { attempt, oneLine } from './status.js';
import { LEVELS, percent, wishOfShare } from './sizes.js';
import { copy, sizeOf } from './save.js';

const at = (id) => document.getElementById(id);

/** Creates a button for each level, the finest last; `choose(share)` is called on a click. */
export function makeLevels(choose) {
  for (const share of [...LEVELS].sort((a, b) => a - b)) {
    const button = element('button', '', { type: 'button' });
    button.append(element('canvas', '', { width: 176, height: 132, ariaHidden: 'true' }), element('strong', percent(share)), element('span', ''), element('span', ''));
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
    smallWords(results.get(key)).forEach((words, i) => { button.querySelectorAll('span')[i].textContent = words; });
    button.firstChild.dataset.wished = key;
  }
}

/** Returns the canvas of the level that a result is; null if it is none. */
export function levelCanvas({ wish }, options) {
  if (JSON.stringify(wish.options) !== JSON.stringify(options)) return null;
  return [...at('levels').querySelectorAll('canvas')].find(({ dataset }) => dataset.wished === wish.key) ?? null;
}

/** Returns the size and, once measured, the distance of a level. */
function smallWords(result) {
  if (!result) return ['', ''];
  const mean = result.comparison?.results[0].values.distance_mean;
  return [`${count(result.mesh.faces.length / 3)} faces`, Number.isFinite(mean) ? percentOff(mean) : ''];
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

/** Shows the file size of the format that exists already, whose button stands out. */
export function showDownloads({ ending: ready, shown }) {
  at('ready-size').textContent = shown ? `${ready.toUpperCase()}: ${spokenBytes(sizeOf(shown.file))}` : '';
  for (const button of at('downloads').children) {
    const { ending } = button.dataset;
    button.classList.toggle('main', ending === ready);
    button.disabled = !shown;
  }
}

/** Fills the table with the figures of the shown result; those that are not measured yet are empty. */
export function showFigures({ file, mesh, shown }) {
  const { comparison } = shown;
  const original = { vertices: mesh.positions.length / 3, ...comparison?.original, faces: mesh.faces.length / 3, bytes: sizeOf(file) };
  const values = comparison?.results[0].values ?? { faces: shown.mesh.faces.length / 3 };
  at('no-figures').hidden = Boolean(comparison);
  at('figures').replaceChildren();
  fillTable(at('figures'), {
    original, figures: comparison?.figures ?? [], results: [{ name: shown.wish.title, bytes: sizeOf(shown.file), values }],
  }, { hasAll: true });
  showColumn(at('figures'), 0);
  if (comparison && at('meanings').children.length === 0) fillMeanings(at('meanings'), comparison.figures);
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

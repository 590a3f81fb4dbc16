// Wires up the inputs for files, and the controls of size and options.

import { element } from '../../../cli/viewer/src/element.js';
import { EXAMPLES } from './examples.js';
import gear from './examples/gear.webp';
import knot from './examples/knot.webp';
import planet from './examples/planet.webp';
import { filesOfDrop, filesOfInput } from './files.js';

/** Milliseconds without a change after which a slider's value counts as chosen, as arrow keys change it step by step. */
const SETTLED = 350;

/** Pictures of the examples, which test/examples.js takes. */
const PICTURES = { Knot: knot, Gear: gear, Planet: planet };

const at = (id) => document.getElementById(id);

/** Wires up buttons, inputs and dropping; `open(files)` is called with the chosen files, `openExample(make)` with an example's maker. */
export function wireDoors(open, openExample) {
  at('examples').replaceChildren(...Object.entries(EXAMPLES).map(([name, make]) => {
    const button = element('button', '', { type: 'button' });
    button.dataset.example = name;
    button.append(element('img', '', { src: PICTURES[name], alt: '', width: 352, height: 264 }), name);
    button.addEventListener('click', () => openExample(make));
    return button;
  }));
  const doors = [['choose', 'files'], ['choose-here', 'files'], ['choose-folder', 'folder'], ['choose-folder-here', 'folder']];
  for (const [button, input] of doors) {
    at(button).addEventListener('click', () => at(input).click());
  }
  // Some phones cannot choose folders.
  for (const id of ['choose-folder', 'choose-folder-here']) at(id).hidden = !('webkitdirectory' in at('folder'));
  for (const input of [at('files'), at('folder')]) {
    input.addEventListener('change', () => {
      open(filesOfInput(input));
      // Clearing the value allows to choose a file twice.
      input.value = '';
    });
  }
  let depth = 0;
  const hint = (by) => {
    depth = Math.max(depth + by, 0);
    document.documentElement.toggleAttribute('data-over', depth > 0);
  };
  addEventListener('dragenter', (event) => { event.preventDefault(); hint(1); });
  addEventListener('dragleave', () => hint(-1));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', async (event) => {
    event.preventDefault();
    hint(-Infinity);
    open(await filesOfDrop(event.dataTransfer).catch(() => []));
  });
}

/** Wires up size and options: `drag()` is called for each step of the slider, `settle()` when a value is chosen. */
export function wireSizes({ drag, settle }) {
  let timer = 0;
  const soon = () => {
    clearTimeout(timer);
    timer = setTimeout(settle, SETTLED);
  };
  at('share').addEventListener('input', drag);
  for (const id of ['share', 'faces', 'error', 'optimize', 'effort', 'keep_features', 'lock_boundaries', 'subset']) {
    at(id).addEventListener('change', soon);
  }
  at('by').addEventListener('change', () => {
    for (const way of ['ratio', 'faces', 'error']) at(`by-${way}`).hidden = at('by').value !== way;
    soon();
  });
}

// Opens the file in a page, and files that the reader chooses or drops; each replaces the one before.

import { bytesOf } from './numbers.js';
import { attempt, markFirstDraw, wait } from './stage.js';

const at = (id) => document.getElementById(id);

/**
 * Creates an opener and listens. `read(blob, facts)` reads a file, `show(content, refuse)` shows it; `refuse(error)` says in one line why
 * it cannot be shown. `facts` are what the program wrote beside the file in the page. `words` are {command, loading, empty}: the program's command, and messages while a file loads and without one.
 */
export function makeOpener({ words, read, show }) {
  const opener = { words, read, show, nOpened: 0, isOpening: false };
  const openFile = (file) => { if (file) attempt(open(opener, file.name, async () => file)); };
  at('file').addEventListener('change', () => openFile(at('file').files[0]));
  at('choose').addEventListener('click', () => at('file').click());
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    openFile(event.dataTransfer.files[0]);
  });
  return opener;
}

/** Opens the file in the page, if there is one. */
export function openEmbedded(opener) {
  const embedded = at('embedded');
  if (!embedded) {
    wait(opener.words.empty);
    markFirstDraw();
    return;
  }
  const facts = JSON.parse(embedded.textContent);
  open(opener, facts.name, async () => {
    const stream = new Blob(await bytesOf('embedded')).stream().pipeThrough(new DecompressionStream('deflate-raw'));
    return new Response(stream).blob();
  }, facts);
}

/** Ends the opening of a file when a frame of it is drawn. */
export function markOpened(opener) {
  if (!opener.isOpening) return;
  opener.isOpening = false;
  wait('');
  markFirstDraw();
}

async function open(opener, name, load, facts = {}) {
  const turn = ++opener.nOpened;
  const refuse = (error) => {
    if (turn !== opener.nOpened) return;
    opener.isOpening = false;
    wait(`${name}: ${error.message}`);
  };
  opener.isOpening = true;
  wait(opener.words.loading);
  try {
    const content = await opener.read(await load(), facts);
    if (turn !== opener.nOpened) return;
    opener.show(content, refuse);
    at('name').textContent = name;
    document.title = `${name} - neural-mesh ${opener.words.command}`;
  } catch (error) {
    refuse(error);
  }
}

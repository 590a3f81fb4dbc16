// The keyboard: arrows move the camera while the view has the focus, letters press the page's switches anywhere.

import { lookFromStart, orbit, pan, zoom } from './view.js';

const TURN = Math.PI / 24;
const STEP = 0.03;

/** Camera moves by key: without and with Shift. */
const CAMERA = {
  ArrowLeft: [(view) => orbit(view, -TURN, 0), (view) => pan(view, STEP, 0)],
  ArrowRight: [(view) => orbit(view, TURN, 0), (view) => pan(view, -STEP, 0)],
  ArrowUp: [(view) => orbit(view, 0, TURN), (view) => pan(view, 0, -STEP)],
  ArrowDown: [(view) => orbit(view, 0, -TURN), (view) => pan(view, 0, STEP)],
  '+': [(view) => zoom(view, 0.9)],
  '=': [(view) => zoom(view, 0.9)],
  '-': [(view) => zoom(view, 1 / 0.9)],
  _: [(view) => zoom(view, 1 / 0.9)],
  Home: [(view) => lookFromStart(view)],
};

/** Listens to the keys of a view, and to the letters that `data-key` of an element names. */
export function listen(view, canvas) {
  canvas.addEventListener('keydown', (event) => {
    const actions = CAMERA[event.key];
    if (!actions || isShortcut(event)) return;
    event.preventDefault();
    (event.shiftKey && actions[1] ? actions[1] : actions[0])(view);
  });
  document.addEventListener('keydown', (event) => {
    if (isShortcut(event) || isThirdLevel(event) || isTyping(event.target)) return;
    const element = document.querySelector(`[data-key="${CSS.escape(event.key.toLowerCase())}"]`);
    if (element && !element.disabled) element.click();
  });
}

/** Returns whether a key is meant for the browser or the system. */
function isShortcut(event) {
  return event.metaKey || ((event.ctrlKey || event.altKey) && !isThirdLevel(event));
}

/** Returns whether AltGr is pressed, which some systems report as Ctrl and Alt; some keyboards need it for + and -. */
function isThirdLevel(event) {
  return event.getModifierState('AltGraph');
}

function isTyping(element) {
  return element.matches?.('input[type="number"], input[type="text"], select, textarea');
}

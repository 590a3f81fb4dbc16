// The divider between the original on its left and the result on its right, moved by pointer and keys.

import { setWipe } from './view.js';

const STEP = 0.02;

/** Changes by key of the share of the width that shows the original. */
const MOVES = {
  ArrowLeft: (share) => share - STEP, ArrowDown: (share) => share - STEP,
  ArrowRight: (share) => share + STEP, ArrowUp: (share) => share + STEP,
  PageDown: (share) => share - 5 * STEP, PageUp: (share) => share + 5 * STEP,
  Home: () => 0, End: () => 1,
};

/** Wires up switch and divider of a view. */
export function wireWipe(view) {
  const [box, divider, frame] = ['wipe', 'divider', 'frame'].map((id) => document.getElementById(id));
  let share = 0.5;
  const show = () => {
    frame.classList.toggle('wiped', box.checked);
    divider.hidden = !box.checked;
    divider.style.left = `${100 * share}%`;
    frame.style.setProperty('--wipe', `${100 * share}%`);
    divider.ariaValueNow = String(Math.round(100 * share));
    divider.ariaValueText = `original ${Math.round(100 * share)} %, result ${Math.round(100 - 100 * share)} %`;
    setWipe(view, box.checked ? share : null);
  };
  const move = (to) => {
    share = Math.min(Math.max(to, 0), 1);
    show();
  };
  const follow = ({ clientX }) => {
    const { left, width } = frame.getBoundingClientRect();
    move((clientX - left) / width);
  };
  box.addEventListener('change', show);
  show();
  divider.addEventListener('pointerdown', (event) => {
    divider.setPointerCapture(event.pointerId);
    divider.focus();
    event.preventDefault();
  });
  divider.addEventListener('pointermove', (event) => { if (divider.hasPointerCapture(event.pointerId)) follow(event); });
  divider.addEventListener('keydown', (event) => {
    if (!MOVES[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    move(MOVES[event.key](share));
  });
}

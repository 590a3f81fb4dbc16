// The colour bar: the distances that colours mean; the reader chooses the end of the scale and the unit.

import { GRADIENT } from './colours.js';
import { short } from './words.js';

const TICKS = [0, 0.25, 0.5, 0.75, 1];

/** Text about the distances above each end of the scale. */
const BEYOND = {
  p95: '5 % of the surfaces are farther and have the last colour.',
  p99: '1 % of the surfaces is farther and has the last colour.',
  max: 'The largest distance.',
  own: 'Larger distances have the last colour.',
};

/**
 * Wires up the bar; `changed(share)` is called with the end of the scale, as a share of the largest distance. The returned function shows
 * another scale, of meshes with this diagonal.
 */
export function makeBar(changed) {
  const [end, own, unit] = ['end', 'own', 'unit'].map((id) => document.getElementById(id));
  document.getElementById('gradient').style.background = GRADIENT;
  let [scale, diagonal, length] = [{ p95: 0, p99: 0, max: 0 }, 0, 0];
  const inUnit = () => (unit.value === 'percent' ? 100 / diagonal : 1);
  const update = () => {
    if (end.value !== 'own') length = scale[end.value] || scale.max;
    own.hidden = end.value !== 'own';
    write(length * inUnit(), BEYOND[end.value]);
    changed(scale.max > 0 ? length / scale.max : 1);
  };
  const type = () => {
    if (own.valueAsNumber > 0) length = own.valueAsNumber / inUnit();
    update();
  };
  const fill = () => { own.value = short(length * inUnit()); };
  end.addEventListener('change', () => { fill(); update(); });
  unit.addEventListener('change', () => { fill(); update(); });
  own.addEventListener('input', type);
  return (newScale, newDiagonal) => {
    [scale, diagonal] = [newScale, newDiagonal];
    // A share of the diagonal is undefined if the diagonal is 0.
    if (!(diagonal > 0)) unit.value = 'own';
    if (end.value === 'own') return type();
    length = scale[end.value] || scale.max;
    fill();
    return update();
  };
}

/** Formats ticks with equal numbers of decimals. */
function tick(value, end) {
  if (value === 0) return '0';
  if (end < 1e-4 || end >= 1e6) return value.toExponential(2);
  return value.toFixed(Math.max(2 - Math.floor(Math.log10(end)), 0));
}

function write(end, beyond) {
  const ticks = TICKS.map((share) => Object.assign(document.createElement('span'), { textContent: tick(share * end, end) }));
  document.getElementById('ticks').replaceChildren(...ticks);
  document.getElementById('beyond').textContent = beyond;
}

// Scales of plot axes: map values to positions, and choose round numbers for ticks. A scale is logarithmic if the values allow it.

import { short } from './words.js';

/** Returns a scale over values: logarithmic if none is below 0 and most are above; zeros are then at its lower end. */
export function scaleOf(values) {
  let [low, high, least, nAbove, nBelow, n] = [Infinity, -Infinity, Infinity, 0, 0, 0];
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    n++;
    low = Math.min(low, value);
    high = Math.max(high, value);
    if (value > 0) { nAbove++; least = Math.min(least, value); }
    if (value < 0) nBelow++;
  }
  if (n === 0) return { isLog: false, low: 0, high: 1 };
  if (nBelow === 0 && nAbove > n / 2) {
    const room = Math.max((high / least) ** 0.06, 1.1);
    return { isLog: true, low: least / room, high: high * room };
  }
  const room = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1;
  return { isLog: false, low: low - room, high: high + room };
}

/** Returns the position of a value on a scale, 0 to 1. */
export function shareOf({ isLog, low, high }, value) {
  if (!isLog) return (value - low) / (high - low);
  return value > low ? Math.log(value / low) / Math.log(high / low) : 0;
}

/** Returns at most about n round values along a scale, with labels. */
export function ticksOf(scale, n) {
  const values = scale.isLog ? logTicks(scale, n) : evenTicks(scale, n);
  return values.map((value) => ({ value, words: tick(value) }));
}

function tick(value) {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential().replace('+', '') : short(value);
}

function evenTicks({ low, high }, n) {
  const rough = (high - low) / n;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((times) => power * times >= rough);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

/** Returns powers of ten, with 2 and 5 between them if there is room; even steps below a decade. */
function logTicks(scale, n) {
  const [from, to] = [Math.floor(Math.log10(scale.low)), Math.ceil(Math.log10(scale.high))];
  const decades = Array.from({ length: to - from + 1 }, (_, i) => from + i);
  const inside = (times, every) => decades.filter((decade) => decade % every === 0)
    .flatMap((decade) => times.map((time) => Number(`${time}e${decade}`)))
    .filter((value) => value >= scale.low && value <= scale.high);
  const finer = [[1, 2, 3, 5, 7], [1, 2, 5], [1, 3], [1]].map((times) => inside(times, 1));
  const coarser = [2, 3, 4, 6, 10, 20].map((every) => inside([1], every));
  const found = [...finer, ...coarser].find((values) => values.length <= n) ?? [];
  return found.length >= 3 ? found : evenTicks(scale, Math.min(n, 4)).filter((value) => value > 0);
}

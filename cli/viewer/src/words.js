// Numbers as people read them, as the program's own table has them.

const whole = new Intl.NumberFormat('en-US', { maximumFractionDigits: 0 });

/** A count with commas. */
export function count(n) {
  return whole.format(n);
}

/** Four significant digits; whole numbers whole; a dash where there is no value. */
export function number(value) {
  if (value === null || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e15) return whole.format(value);
  if (size < 1e-4 || size >= 1e7) return value.toExponential(3);
  return value.toFixed(Math.max(3 - Math.floor(Math.log10(size)), 0));
}

/** Three significant digits without an exponent where possible. */
export function short(value) {
  return value === 0 ? '0' : String(Number(value.toPrecision(3)));
}

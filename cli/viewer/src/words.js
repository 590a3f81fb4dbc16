// Numbers as people read them, as the program's own table has them.

const whole = new Intl.NumberFormat('en-US', { maximumFractionDigits: 0 });

/** The name of a figure as people say it. */
export function spoken(name) {
  return name.replaceAll('_', ' ');
}

/** A count with commas. */
export function count(n) {
  return whole.format(n);
}

/** Four significant digits, or as many as asked for; whole numbers whole; a dash where there is no value. */
export function number(value, digits = 4) {
  if (value === null || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return whole.format(value);
  return precise(value, digits);
}

/** So many significant digits, also where they are zeros. */
export function precise(value, digits) {
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size < 1e-4 || size >= 1e7) return value.toExponential(digits - 1);
  return value.toFixed(Math.max(digits - 1 - Math.floor(Math.log10(size)), 0));
}

/** Three significant digits without an exponent where possible. */
export function short(value) {
  return value === 0 ? '0' : String(Number(value.toPrecision(3)));
}

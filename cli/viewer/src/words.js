// Formats numbers as in the program's own table.

const whole = new Intl.NumberFormat('en-US', { maximumFractionDigits: 0 });

/** Returns the readable name of a figure. */
export function spoken(name) {
  return name.replaceAll('_', ' ');
}

/** Formats a count with commas. */
export function count(n) {
  return whole.format(n);
}

/** Formats a value with four significant digits by default; integers in full; a dash for no value. */
export function number(value, digits = 4) {
  if (value === null || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return whole.format(value);
  return precise(value, digits);
}

/** Formats a value with a number of significant digits, trailing zeros included. */
export function precise(value, digits) {
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size < 1e-4 || size >= 1e7) return value.toExponential(digits - 1);
  return value.toFixed(Math.max(digits - 1 - Math.floor(Math.log10(size)), 0));
}

/** Formats a value with three significant digits, without an exponent if possible. */
export function short(value) {
  return value === 0 ? '0' : String(Number(value.toPrecision(3)));
}

// Stores vertex attributes in single precision or as integers, which may be normalized to -1..1 or 0..1.

const LIMITS = [
  [Int8Array, -128, 127], [Uint8Array, 0, 255], [Uint8ClampedArray, 0, 255],
  [Int16Array, -32768, 32767], [Uint16Array, 0, 65535], [Int32Array, -2147483648, 2147483647], [Uint32Array, 0, 4294967295],
];

/** Stores numbers in a typed array of a class, rounded and clamped to its range. */
export function storeNumbers(values, type, normalized) {
  const [, least, most] = LIMITS.find(([limited]) => limited === type) ?? [];
  if (most === undefined) return type.from(values);
  const scale = normalized ? most : 1;
  return type.from(values, (value) => Math.max(least, Math.min(most, Math.round(scale * value))));
}

/** Scales the first three numbers of each row to length 1; rows of zeros stay. */
export function normalizeRows(values, width) {
  for (let i = 0; i < values.length; i += width) {
    const length = Math.hypot(values[i], values[i + 1], values[i + 2]) || 1;
    for (let j = 0; j < 3; j++) values[i + j] /= length;
  }
  return values;
}

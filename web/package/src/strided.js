// Packs and unpacks the first numbers of each row of a strided array.

/** Returns the first `width` numbers of each row of `stride`; the array itself if both are equal. */
export function packRows(array, stride, width) {
  if (stride === width) return array;
  const packed = new array.constructor((array.length / stride || 0) * width);
  for (let from = 0, to = 0; from < array.length; from += stride) {
    for (let i = 0; i < width; i++) packed[to++] = array[from + i];
  }
  return packed;
}

/** Writes packed rows over the first `width` numbers of each row of `stride`. */
export function unpackRows(packed, array, stride, width) {
  for (let from = 0, to = 0; from < packed.length; from += width, to += stride) {
    for (let i = 0; i < width; i++) array[to + i] = packed[from + i];
  }
}

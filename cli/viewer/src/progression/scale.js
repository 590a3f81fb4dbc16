// Map between a mesh's coordinates and unit size: a shift and a power of two, as the library's `surface.rs` chooses them.

/** Returns {centre, factor} for positions, 3 numbers each. */
export function scaleOf(positions) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let i = 0; i < positions.length; i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  const [x, y, z] = low.map((from, axis) => high[axis] - from);
  const diagonal = Math.sqrt(x * x + y * y + z * z);
  const centre = low.map((from, axis) => Math.fround((from + high[axis]) * 0.5));
  return { centre, factor: diagonal > 0 ? 2 ** -Math.round(Math.log2(diagonal)) : 1, diagonal };
}

/** Returns positions at unit size, then those of the copied vertices. */
export function normalise(positions, copies, { centre, factor }) {
  const n = positions.length;
  const unit = new Float32Array(n + 3 * copies.length);
  for (let i = 0; i < n; i++) unit[i] = (positions[i] - centre[i % 3]) * factor;
  copies.forEach((vertex, i) => unit.set(unit.subarray(3 * vertex, 3 * vertex + 3), n + 3 * i));
  return unit;
}

/** Returns positions in the mesh's coordinates. */
export function restore(unit, { centre, factor }) {
  return unit.map((x, i) => x / factor + centre[i % 3]);
}

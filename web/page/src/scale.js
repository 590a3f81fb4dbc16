// Finds the ends of the colour scale of distances: quantiles over the area of both surfaces.

const N_BINS = 1 << 16;

/** Returns the largest distance of a pair of meshes, and the 95 % and 99 % quantiles by area. */
export function scaleOf(pairs) {
  let max = 0;
  for (const { values } of pairs) for (const value of values) if (value > max) max = value;
  if (max === 0) return { p95: 0, p99: 0, max };
  const bins = new Float64Array(N_BINS);
  for (const { values, mesh } of pairs) {
    const weights = areasOf(mesh);
    // Both surfaces have equal weight.
    const total = weights.reduce((sum, weight) => sum + weight, 0) || 1;
    values.forEach((value, i) => { bins[Math.min(Math.floor((value / max) * N_BINS), N_BINS - 1)] += (weights[i] ?? 0) / total; });
  }
  const quantile = (share) => {
    let [below, bin] = [0, 0];
    while (bin < N_BINS && (below += bins[bin]) < share * pairs.length) bin++;
    return (Math.min(bin + 1, N_BINS) / N_BINS) * max;
  };
  return { p95: quantile(0.95), p99: quantile(0.99), max };
}

/** Returns the area around each vertex. */
function areasOf({ positions, faces }) {
  const areas = new Float64Array(positions.length / 3);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [3 * faces[i], 3 * faces[i + 1], 3 * faces[i + 2]];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const area = Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
    for (const corner of [a, b, c]) areas[corner / 3] += area;
  }
  return areas;
}

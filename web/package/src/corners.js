// Corners of triangles at vertices of another part. Where vertices are few, the boundary between two parts may move to a vertex that one of
// them alone had; the other one gets a copy of it there.

/**
 * Gives each part its own vertices.
 *
 * @param {{indices: Uint32Array, groups: Uint32Array}} triangles three vertices and the part of each
 * @param {Float32Array} positions n x 3
 * @param {number[]} starts the first vertex of each part, and n
 * @returns {{indices: Uint32Array, sources: Uint32Array, looks: Uint32Array}} the triangles; for each vertex, copies behind the others, the
 *   vertex that has its place, and the one that has its look: the nearest of the part, itself where it is no copy
 */
export function separateParts({ indices, groups }, positions, starts) {
  const n = starts.at(-1);
  const copies = new Map();
  const [sources, looks] = [[], []];
  const copyOf = (vertex, part) => {
    const key = part * n + vertex;
    if (!copies.has(key)) {
      copies.set(key, n + sources.push(vertex) - 1);
      looks.push(nearestVertex(positions, vertex, starts[part], starts[part + 1]));
    }
    return copies.get(key);
  };
  const separate = indices.map((vertex, corner) => {
    const part = groups[Math.floor(corner / 3)];
    return vertex >= starts[part] && vertex < starts[part + 1] ? vertex : copyOf(vertex, part);
  });
  const withCopies = (list) => Uint32Array.from({ length: n + list.length }, (_, i) => (i < n ? i : list[i - n]));
  return { indices: separate, sources: withCopies(sources), looks: withCopies(looks) };
}

/** The vertex between two numbers that is nearest to another one. */
function nearestVertex(positions, vertex, from, to) {
  const [x, y, z] = positions.subarray(3 * vertex, 3 * vertex + 3);
  let [nearest, least] = [from, Infinity];
  for (let i = from; i < to; i++) {
    const distance = (positions[3 * i] - x) ** 2 + (positions[3 * i + 1] - y) ** 2 + (positions[3 * i + 2] - z) ** 2;
    if (distance < least) [nearest, least] = [i, distance];
  }
  return nearest;
}

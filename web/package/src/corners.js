// Gives each part of a surface its own vertices. The simplifier may move the border between two parts to a vertex that only one of them
// has; the other part then gets a copy of it.

/**
 * Copies vertices so that the triangles of each part use only vertices of that part.
 *
 * @param {{indices: Uint32Array, groups: Uint32Array}} triangles three vertices and the part of each triangle
 * @param {Float32Array} positions n x 3
 * @param {number[]} starts the first vertex of each part, and n
 * @returns {{indices: Uint32Array, sources: Uint32Array, looks: Uint32Array}} the triangles; and for each vertex, copies last, the vertex
 *   with its position, and the vertex with its other attributes: itself, or for a copy the closest vertex of the part
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

/** Returns the vertex in a range of numbers that is closest to a vertex. */
function nearestVertex(positions, vertex, from, to) {
  const [x, y, z] = positions.subarray(3 * vertex, 3 * vertex + 3);
  let [nearest, least] = [from, Infinity];
  for (let i = from; i < to; i++) {
    const distance = (positions[3 * i] - x) ** 2 + (positions[3 * i + 1] - y) ** 2 + (positions[3 * i + 2] - z) ** 2;
    if (distance < least) [nearest, least] = [i, distance];
  }
  return nearest;
}

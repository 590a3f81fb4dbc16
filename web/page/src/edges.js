// Finds the edges of a welded mesh, and those that are open, non-manifold, or between faces of inconsistent winding.

/** Finds `all` edges and the `marked` ones by kind, each as two vertices; degenerate faces are left out. */
export function findEdges(faces, nVertices) {
  const keys = sortedKeys(faces, nVertices);
  const all = new Uint32Array(2 * keys.length);
  let n = 0;
  const marked = [[], [], []];
  for (let from = 0, to; from < keys.length; from = to) {
    const edge = Math.floor(keys[from] / 2);
    for (to = from + 1; to < keys.length && Math.floor(keys[to] / 2) === edge;) to++;
    const ends = [Math.floor(edge / nVertices), edge % nVertices];
    all.set(ends, 2 * n++);
    const kind = kindOf(keys, from, to);
    if (kind !== null) marked[kind].push(...ends);
  }
  return { all: all.subarray(0, 2 * n), marked: marked.map((edges) => Uint32Array.from(edges)) };
}

/** Returns a number for each half-edge: twice its edge, plus one if it starts at the larger vertex. */
function sortedKeys(faces, nVertices) {
  const keys = new Float64Array(faces.length);
  let n = 0;
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [faces[i], faces[i + 1], faces[i + 2]];
    if (a === b || b === c || c === a) continue;
    for (const [from, to] of [[a, b], [b, c], [c, a]]) {
      keys[n++] = from < to ? 2 * (from * nVertices + to) : 2 * (to * nVertices + from) + 1;
    }
  }
  return keys.subarray(0, n).sort();
}

/** Returns the kind of an edge: 0 open, 1 non-manifold, 2 turned; null if two faces have opposite directions along it. */
function kindOf(keys, from, to) {
  if (to - from === 1) return 0;
  if (to - from > 2) return 1;
  return keys[from] === keys[from + 1] ? 2 : null;
}

// Components of a surface: what its faces join.

/** Numbers the components that faces join, of `n` vertices or wedges, in the order of their first ones; returns that of each. */
export function componentsOf(n, faces) {
  const parents = Uint32Array.from({ length: n }, (_, vertex) => vertex);
  const find = (vertex) => {
    while (parents[vertex] !== vertex) {
      parents[vertex] = parents[parents[vertex]];
      vertex = parents[vertex];
    }
    return vertex;
  };
  // The smallest vertex of a component stands for it.
  const join = (a, b) => { parents[Math.max(a, b)] = Math.min(a, b); };
  for (let i = 0; i < faces.length; i += 3) {
    join(find(faces[i]), find(faces[i + 1]));
    join(find(faces[i + 1]), find(faces[i + 2]));
  }
  const components = new Uint32Array(n);
  let nComponents = 0;
  for (let vertex = 0; vertex < n; vertex++) {
    const first = find(vertex);
    components[vertex] = first === vertex ? nComponents++ : components[first];
  }
  return components;
}

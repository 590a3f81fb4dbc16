// Placement of levels in the scene that the file was read from: pieces of the mesh, each with instances.

/** Most faces with all instances; beyond, each piece is shown once. */
const MOST_FACES = 2 ** 23;

/**
 * Returns the piece of each rank, matrices of the instances of each piece, and how many vertices and faces all instances have at
 * most; null for a mesh that stays where it is.
 */
export function makePlacement(stored, groups, surfaceFaces, { n, vertices }) {
  if (!stored) return null;
  const { firstGroups, places } = stored;
  const [pieceOfVertex, nFaces, nVertices] = [new Uint32Array(n), places.map(() => 0), places.map(() => 0)];
  for (let face = 0; face < surfaceFaces.length / 3; face++) {
    const piece = pieceOf(firstGroups, groups[face] ?? 0);
    nFaces[piece]++;
    for (let k = 0; k < 3; k++) pieceOfVertex[surfaceFaces[3 * face + k]] = piece;
  }
  for (const piece of pieceOfVertex) nVertices[piece]++;
  const sum = (instances, counts) => instances.reduce((total, { length }, piece) => total + length * counts[piece], 0);
  const shown = sum(places, nFaces) > MOST_FACES ? places.map((instances) => instances.slice(0, 1)) : places;
  // A scene without nodes shows its meshes as they are.
  if (sum(shown, nFaces) === 0) return null;
  return {
    pieceOfRank: Uint32Array.from(vertices, (vertex) => pieceOfVertex[vertex]), places: shown,
    most: { nVertices: sum(shown, nVertices), nFaces: sum(shown, nFaces) },
  };
}

/** Returns the piece of a group, the last one that begins with it or before. */
function pieceOf(firstGroups, group) {
  let piece = 0;
  while (piece + 2 < firstGroups.length && firstGroups[piece + 1] <= group) piece++;
  return piece;
}

/** The matrix that moves nothing. */
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/**
 * Lists the instances of a level, whose vertices have these ranks: matrix, whether it mirrors, and numbers of vertices and faces. Without
 * a placement it is one, of everything.
 */
export function listInstances(placement, ranks, faces) {
  const nFaces = faces.length / 3;
  const { pieceOfRank, places } = placement ?? { pieceOfRank: null, places: [[IDENTITY]] };
  const pieceAt = (vertex) => pieceOfRank?.[ranks[vertex]] ?? 0;
  const vertices = listsBy(ranks.length, places.length, pieceAt);
  const ownFaces = listsBy(nFaces, places.length, (face) => pieceAt(faces[3 * face]));
  return places.flatMap((instances, piece) => instances.map((matrix) => ({
    matrix, isMirrored: determinant(matrix) < 0, vertices: vertices[piece], faces: ownFaces[piece],
  })));
}

/** Writes all instances of a level into positions of 3 numbers and faces; returns the numbers of both. */
export function placeLevel(placement, ranks, { positions, faces }, into) {
  const numbers = new Uint32Array(ranks.length);
  const placed = { nVertices: 0, nFaces: 0 };
  for (const { matrix, isMirrored, vertices, faces: own } of listInstances(placement, ranks, faces)) {
    for (const vertex of vertices) {
      numbers[vertex] = placed.nVertices;
      movePoint(matrix, positions, 3 * vertex, into.positions, 3 * placed.nVertices++);
    }
    for (const face of own) {
      const at = 3 * placed.nFaces++;
      for (let k = 0; k < 3; k++) into.faces[at + k] = numbers[faces[3 * face + cornerOf(k, isMirrored)]];
    }
  }
  return placed;
}

/** Returns the corner of a face that comes at a place, in the other order in mirrored instances. */
export function cornerOf(k, isMirrored) {
  return isMirrored ? (3 - k) % 3 : k;
}

/** Returns a direction that is perpendicular to the moved surface, of length 1, as normals have to be. */
export function moveNormal(m, [x, y, z]) {
  const cofactors = [0, 1, 2].map((row) => [0, 1, 2].map((column) => cofactor(m, row, column)));
  const moved = cofactors.map(([a, b, c]) => a * x + b * y + c * z);
  const length = Math.hypot(...moved) * (determinant(m) < 0 ? -1 : 1);
  return length === 0 ? [x, y, z] : moved.map((value) => value / length);
}

/** Sorts the numbers below n into lists. */
function listsBy(n, nLists, listOf) {
  const sizes = new Uint32Array(nLists);
  for (let i = 0; i < n; i++) sizes[listOf(i)]++;
  const lists = Array.from(sizes, (size) => new Uint32Array(size));
  sizes.fill(0);
  for (let i = 0; i < n; i++) lists[listOf(i)][sizes[listOf(i)]++] = i;
  return lists;
}

/** Moves a point by a matrix of columns. */
export function movePoint(m, from, at, into, to) {
  const [x, y, z] = [from[at], from[at + 1], from[at + 2]];
  for (let row = 0; row < 3; row++) into[to + row] = m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row];
}

function cofactor(m, row, column) {
  const [r, s, c, d] = [(row + 1) % 3, (row + 2) % 3, (column + 1) % 3, (column + 2) % 3];
  return m[4 * c + r] * m[4 * d + s] - m[4 * d + r] * m[4 * c + s];
}

function determinant(m) {
  return [0, 1, 2].reduce((sum, column) => sum + m[4 * column] * cofactor(m, 0, column), 0);
}

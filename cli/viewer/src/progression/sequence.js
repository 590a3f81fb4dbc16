// Vertex splits that lead from the smallest mesh to the whole one, as the library's `split_sequence.rs` makes them.
//
// Vertices are named by rank: the last one that a merge removed comes first, so the vertices of each level are the first ones. Faces
// are sorted by the split that makes them, so the faces of each level are the first ones, too.

import { inSlices } from '../slices.js';
import { check } from './container.js';

/** Largest number of moves of corners: the first per face, plus the second. Merges of a collapse stay far below. */
const MOST_MOVES = [64, 2 ** 20];

const NONE = 0xffffffff;

/**
 * Reverses merges of a surface; `positions` are at unit size, 3 numbers each, and change.
 *
 * `vertices` has the vertex of each rank. `parents`, `parentPositions` and `positions` say what the split that makes a vertex
 * restores. `faceEnds` is the number of faces of each level, `faces` the corners of each face when it is made; `moves` up to
 * `moveEnds` are the corners that move to each vertex. `slots` has the place of each face of the mesh among them.
 */
export async function makeSequence(positions, faces, merges) {
  const n = positions.length / 3;
  const { ranks, parents, vertices, nRoots } = linkVertices(n, merges);
  const splits = await reverseMerges(positions, merges, { ranks, vertices, nRoots });
  const sorted = await sortFaces(faces, { ranks, parents, nRoots, n });
  return { n, nRoots, vertices, ...splits, ...sorted };
}

/** Returns the number of vertices of the largest level within both limits, or else of the smallest. */
export function largestWithin({ n, nRoots, faceEnds }, limit) {
  let [low, high] = [0, n + 1];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (faceEnds[middle] <= limit.faces) low = middle + 1;
    else high = middle;
  }
  return Math.min(Math.max(Math.min(low - 1, limit.vertices), nRoots), n);
}

/** Writes the positions of the level of n vertices, at unit size. */
export function fillPositions({ positions, parents, parentPositions }, n, into) {
  for (let rank = 0; rank < n; rank++) {
    // A vertex of the smallest mesh is its own parent and writes its position twice.
    const [at, parent] = [3 * rank, 3 * parents[rank]];
    into[at] = positions[at];
    into[at + 1] = positions[at + 1];
    into[at + 2] = positions[at + 2];
    into[parent] = parentPositions[at];
    into[parent + 1] = parentPositions[at + 1];
    into[parent + 2] = parentPositions[at + 2];
  }
}

/** Writes the faces of the level of n vertices, by rank; returns their number. */
export function fillFaces({ nRoots, faces, faceEnds, moves, moveEnds }, n, into) {
  into.set(faces.subarray(0, 3 * faceEnds[n]));
  let move = 0;
  for (let rank = nRoots; rank < n; rank++) {
    for (const end = moveEnds[rank]; move < end; move++) into[moves[move]] = rank;
  }
  return faceEnds[n];
}

/** Returns rank and parent of each vertex, and the vertex of each rank. */
function linkVertices(n, merges) {
  const nRoots = n - merges.n;
  check(nRoots > 0, 'as many merges as vertices');
  const [ranks, parents, vertices] = [new Uint32Array(n).fill(NONE), new Uint32Array(n), new Uint32Array(n)];
  for (let i = 0; i < merges.n; i++) {
    const [kept, removed, rank] = [merges.kept[i], merges.removed[i], n - 1 - i];
    // Neither end may have been removed before.
    const remains = kept < n && removed < n && ranks[kept] === NONE && ranks[removed] === NONE;
    check(remains && kept !== removed, 'a merge of a vertex that is gone');
    ranks[removed] = rank;
    parents[removed] = kept;
    vertices[rank] = removed;
  }
  let rank = 0;
  for (let vertex = 0; vertex < n; vertex++) {
    if (ranks[vertex] !== NONE) continue;
    ranks[vertex] = rank;
    parents[vertex] = vertex;
    vertices[rank++] = vertex;
  }
  return { ranks, parents, vertices, nRoots };
}

async function reverseMerges(positions, merges, { ranks, vertices, nRoots }) {
  const n = vertices.length;
  const splits = { parents: new Uint32Array(n), parentPositions: new Float32Array(3 * n), positions: new Float32Array(3 * n) };
  await inSlices(merges.n, (from, to) => {
    for (let i = from; i < to; i++) {
      const [kept, removed, rank] = [3 * merges.kept[i], 3 * merges.removed[i], n - 1 - i];
      splits.parents[rank] = ranks[merges.kept[i]];
      for (let axis = 0; axis < 3; axis++) {
        splits.parentPositions[3 * rank + axis] = positions[kept + axis];
        splits.positions[3 * rank + axis] = positions[removed + axis];
        positions[kept + axis] = merges.positions[3 * i + axis];
      }
    }
  });
  for (let rank = 0; rank < nRoots; rank++) {
    const place = positions.subarray(3 * vertices[rank], 3 * vertices[rank] + 3);
    splits.parents[rank] = rank;
    splits.parentPositions.set(place, 3 * rank);
    splits.positions.set(place, 3 * rank);
  }
  return splits;
}

/** Sorts faces by the split that makes them, and corners by the vertex to which they move. */
async function sortFaces(surfaceFaces, links) {
  const { births, made, nMoves } = await findBirths(surfaceFaces, links);
  const { faces, faceEnds, slots } = placeFaces(births, made, links.n);
  // Counts become the starts of rows, which grow to their ends.
  const moveEnds = nMoves;
  let sum = 0;
  for (let rank = 0; rank < links.n; rank++) {
    sum += moveEnds[rank];
    moveEnds[rank] = sum - moveEnds[rank];
  }
  const [moves, corners] = [new Uint32Array(sum), new Uint32Array(3)];
  let slot = 0;
  const move = (vertex, corner) => { moves[moveEnds[vertex]++] = 3 * slot + corner; };
  await inSlices(slots.length, (from, to) => {
    for (let face = from; face < to; face++) {
      slot = slots[face];
      followCorners(surfaceFaces, face, links, corners, move);
    }
  });
  return { faces, faceEnds, moves, moveEnds, slots };
}

/** Returns for each face the vertex whose split makes it and its corners then, and how many corners move to each vertex. */
async function findBirths(surfaceFaces, links) {
  const nFaces = surfaceFaces.length / 3;
  const [births, made, nMoves] = [new Uint32Array(nFaces), new Uint32Array(3 * nFaces), new Uint32Array(links.n)];
  const [most, corners] = [MOST_MOVES[0] * nFaces + MOST_MOVES[1], new Uint32Array(3)];
  let sum = 0;
  const note = (vertex) => {
    nMoves[vertex]++;
    sum++;
  };
  await inSlices(nFaces, (from, to) => {
    for (let face = from; face < to; face++) {
      births[face] = followCorners(surfaceFaces, face, links, corners, note);
      made.set(corners, 3 * face);
      check(sum <= most, 'merges that are no mesh\'s');
    }
  });
  return { births, made, nMoves };
}

/** Sorts faces by their births; `slots` has the place of each. */
function placeFaces(births, made, n) {
  const [faceEnds, slots, faces] = [new Uint32Array(n + 1), new Uint32Array(births.length), new Uint32Array(made.length)];
  for (const birth of births) faceEnds[birth + 1]++;
  for (let rank = 0; rank < n; rank++) faceEnds[rank + 1] += faceEnds[rank];
  const next = faceEnds.slice();
  for (let face = 0; face < births.length; face++) {
    slots[face] = next[births[face]]++;
    faces.set(made.subarray(3 * face, 3 * face + 3), 3 * slots[face]);
  }
  return { faces, faceEnds, slots };
}

/**
 * Follows a face's corners through the merges until it vanishes or all corners are of the smallest mesh.
 *
 * Calls `visit` with each vertex that leaves the face, by rank, and its corner. Returns the vertex whose split makes the face; `made`
 * has the corners then, by rank.
 */
function followCorners(faces, face, { ranks, parents, nRoots }, made, visit) {
  let [a, b, c] = [faces[3 * face], faces[3 * face + 1], faces[3 * face + 2]];
  for (;;) {
    made[0] = ranks[a];
    made[1] = ranks[b];
    made[2] = ranks[c];
    // The corner that is removed first has the largest rank.
    const k = made[0] > made[1] ? (made[0] > made[2] ? 0 : 2) : (made[1] > made[2] ? 1 : 2);
    if (made[k] < nRoots) return nRoots - 1;
    const parent = parents[k === 0 ? a : k === 1 ? b : c];
    if (parent === a || parent === b || parent === c) return made[k];
    visit(made[k], k);
    if (k === 0) a = parent;
    else if (k === 1) b = parent;
    else c = parent;
  }
}

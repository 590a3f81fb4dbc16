// Levels of a progression: which vertices and faces a size has, as the library's `progression.rs` decides.

import { componentsOf } from './components.js';
import { fillFaces, fillPositions, largestWithin, makeSequence } from './sequence.js';
import { check, readProgression } from './container.js';
import { readMaterials } from './materials.js';
import { makePlacement } from './placement.js';
import { normalise, restore, scaleOf } from './scale.js';

/** No limit of a size. */
const ALL = { vertices: Infinity, faces: Infinity };
/** Number of drops after which a vertex that no drop removes is gone. */
const NEVER = 0xffff;

/** Reads a file, a blob, and prepares its levels. */
export async function openProgression(file) {
  const { positions, faces, surface, merges, size, drops, proofs, placement, source, ...others } = await readProgression(file);
  const scale = scaleOf(positions);
  const sequence = await makeSequence(normalise(positions, surface.copies, scale), surface.faces, merges);
  return {
    ...others, diagonal: placement?.diagonal ?? scale.diagonal, mesh: { positions, faces }, isMesh: surface.isMesh, surface, scale, sequence, size,
    drops, proofs, isScene: placement !== null, materials: readMaterials(source, placement),
    placement: makePlacement(placement, others.attributes.groups, surface.faces, sequence),
    lasts: drops.length > 0 ? lastsOf(sequence, surface.faces, drops) : null,
  };
}

/** Returns for each rank the number of drops up to which its vertex stays. */
function lastsOf({ n, vertices }, faces, drops) {
  const components = componentsOf(n, faces);
  const nComponents = components.reduce((most, component) => Math.max(most, component + 1), 0);
  check(drops.length < NEVER, 'too many drops');
  const last = new Uint16Array(nComponents).fill(NEVER);
  drops.forEach(({ components: dropped }, i) => {
    for (const component of dropped) {
      check(last[component] === NEVER, 'a component that is dropped twice, or is none');
      last[component] = i;
    }
  });
  check(last.includes(NEVER), 'a level without components');
  return Uint16Array.from(vertices, (vertex) => last[components[vertex]]);
}

/**
 * Finds the level of a size, the largest within {vertices, faces} or else the smallest: its numbers of vertices in the sequence and of
 * drops, and its own numbers of vertices and faces.
 */
export function findLevel(progression, wanted) {
  const { drops, size } = progression;
  const isWhole = wanted.vertices >= size[0] && wanted.faces >= size[1];
  const limit = isWhole ? ALL : wanted;
  let level = levelWithout(progression, limit, 0);
  const isTooLarge = () => level.nVertices > limit.vertices || level.nFaces > limit.faces;
  // Below the smallest form of what is left, the next components go.
  while (level.nDrops < drops.length && (level.nVertices <= drops[level.nDrops].nVertices || isTooLarge())) {
    level = levelWithout(progression, limit, level.nDrops + 1);
  }
  return { ...level, isWhole };
}

/** Finds the level of a size without the components of the first drops. */
function levelWithout({ sequence, lasts }, limit, nDrops) {
  const { n, nRoots, faceEnds, faces } = sequence;
  if (nDrops === 0) {
    const nVertices = largestWithin(sequence, limit);
    return { n: nVertices, nDrops, nVertices, nFaces: faceEnds[nVertices] };
  }
  let [nVertices, nFaces, rank] = [0, 0, nRoots];
  for (let root = 0; root < nRoots; root++) if (lasts[root] >= nDrops) nVertices++;
  for (let face = 0; face < faceEnds[nRoots]; face++) if (lasts[faces[3 * face]] >= nDrops) nFaces++;
  for (; rank < n; rank++) {
    if (lasts[rank] < nDrops) continue;
    const nMore = faceEnds[rank + 1] - faceEnds[rank];
    if (nVertices + 1 > limit.vertices || nFaces + nMore > limit.faces) break;
    nVertices++;
    nFaces += nMore;
  }
  return { n: rank, nDrops, nVertices, nFaces };
}

/** Creates arrays in which every level has room. */
export function makeRoom({ sequence: { n, faces } }) {
  return { positions: new Float32Array(3 * n), faces: new Uint32Array(faces.length) };
}

/** Writes the positions, at unit size, and the faces of a level. */
export function fillLevel({ sequence, lasts }, { n, nDrops }, { positions, faces }) {
  fillPositions(sequence, n, positions);
  const nFaces = fillFaces(sequence, n, faces);
  if (nDrops > 0) removeDropped({ lasts, n, nFaces, nDrops }, { positions, faces });
}

/** Moves the vertices and faces that stay to the front. */
function removeDropped({ lasts, n, nFaces, nDrops }, { positions, faces }) {
  const numbers = new Uint32Array(n);
  let number = 0;
  for (let rank = 0; rank < n; rank++) {
    if (lasts[rank] < nDrops) continue;
    positions.copyWithin(3 * number, 3 * rank, 3 * rank + 3);
    numbers[rank] = number++;
  }
  let to = 0;
  for (let from = 0; from < 3 * nFaces; from += 3) {
    if (lasts[faces[from]] < nDrops) continue;
    for (let k = 0; k < 3; k++) faces[to++] = numbers[faces[from + k]];
  }
}

/** Returns the rank of each vertex of a level. */
export function ranksOf({ lasts }, { n, nDrops }) {
  const all = Uint32Array.from({ length: n }, (_, rank) => rank);
  return nDrops === 0 ? all : all.filter((rank) => lasts[rank] >= nDrops);
}

/** Returns the face of the mesh from which each face of a level comes. */
export function sourceFacesOf({ sequence: { faces, faceEnds, slots }, lasts }, { n, nDrops }) {
  const sources = new Uint32Array(slots.length);
  slots.forEach((slot, face) => { sources[slot] = face; });
  // A face stays in the component in which it is made.
  return sources.subarray(0, faceEnds[n]).filter((_, slot) => nDrops === 0 || lasts[faces[3 * slot]] >= nDrops);
}

/** Returns positions and faces of a level in the mesh's coordinates, as the library makes it without refinement. */
export function meshOfLevel(progression, level) {
  // The original keeps every bit; others pass through unit size.
  if (level.isWhole && progression.isMesh) return progression.mesh;
  const room = makeRoom(progression);
  fillLevel(progression, level, room);
  const positions = room.positions.subarray(0, 3 * level.nVertices);
  return { positions: restore(positions, progression.scale), faces: room.faces.subarray(0, 3 * level.nFaces) };
}

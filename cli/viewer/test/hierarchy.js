// Hierarchies for tests: the file of PAGES, a naive walk over it, and edges of triangles.

import { readFileSync } from 'node:fs';
import { NONE, entriesOf } from '../src/clusters/container.js';
import { errorInPixels } from '../src/clusters/cut.js';

/** Bytes of a hierarchy of a closed mesh, of several pages. */
export const NMC = readFileSync(`${process.env.PAGES}/spot.nmc`);

/** Returns the clusters that are drawn, by descent from the roots: a result too coarse gives way to the clusters of its group. */
export function naiveCut(hierarchy, view, pixels) {
  const { clusters, groups, members } = hierarchy;
  const [drawn, visited] = [new Set(), new Set()];
  const visit = (cluster) => {
    const source = clusters.sources[cluster];
    if (source === NONE || errorInPixels(groups, source, view) <= pixels) return drawn.add(cluster);
    if (visited.has(source)) return drawn;
    visited.add(source);
    return entriesOf(members, source).forEach(visit);
  };
  clusters.groups.forEach((group, cluster) => { if (group === NONE) visit(cluster); });
  return drawn;
}

/** Counts edges that an odd number of triangles share, as positions of 9 numbers per triangle say. */
export function oddEdges(triangles) {
  const odd = new Set();
  const key = (at) => triangles.slice(at, at + 3).join(' ');
  for (let i = 0; i < triangles.length; i += 9) {
    const corners = [key(i), key(i + 3), key(i + 6)];
    corners.forEach((a, k) => {
      const edge = [a, corners[(k + 1) % 3]].sort().join(' to ');
      if (!odd.delete(edge)) odd.add(edge);
    });
  }
  return odd.size;
}

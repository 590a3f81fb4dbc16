// The cut of a hierarchy for a view: the rule of docs/clusters.md, and what is drawn until its pages are loaded.

import { NONE, entriesOf } from './container.js';

/**
 * Returns which groups are too coarse for a view {eye, pixels, near, planes} at an error in pixels, coarse ones first.
 *
 * `eye`, `near` and `planes` (x, y, z, offset; the view is on their positive sides) are in the mesh's coordinates, `pixels` is the
 * height of the image over twice the tangent of half the angle of view.
 */
export function coarseGroups({ groups }, view, most) {
  const [coarse, errors] = [[], new Float64Array(groups.n)];
  for (let group = 0; group < groups.n; group++) {
    errors[group] = errorInPixels(groups, group, view);
    if (errors[group] > most) coarse.push(group);
  }
  // Errors do not fall from a group to the one above it; equal ones are sorted by level.
  return coarse.sort((a, b) => errors[b] - errors[a] || groups.levels[b] - groups.levels[a]);
}

/** Returns a bound of a group's error on the screen. */
export function errorInPixels({ spheres, errors }, group, { eye, pixels, near }) {
  const at = 4 * group;
  const toCentre = Math.hypot(spheres[at] - eye[0], spheres[at + 1] - eye[1], spheres[at + 2] - eye[2]);
  return (errors[group] * pixels) / Math.max(toCentre - spheres[at + 3], near, Number.MIN_VALUE);
}

/** Factor on radii of spheres, whose numbers are rounded. */
const SLACK = 1.001;

/** Returns whether the sphere of a group, or of a cluster, is in the view at least in part. */
export function isInView({ spheres }, index, planes) {
  const at = 4 * index;
  for (const [a, b, c, offset] of planes) {
    if (a * spheres[at] + b * spheres[at + 1] + c * spheres[at + 2] + offset < -SLACK * spheres[at + 3]) return false;
  }
  return true;
}

/**
 * Returns for each group whether its clusters, or finer ones, replace its result: if it is too coarse, its clusters are loaded, and
 * the groups above it are replaced as well. The last two keep the cut closed while pages are missing.
 */
export function replacedGroups({ clusters, groups, results }, coarse, isComplete) {
  const replaced = new Uint8Array(groups.n);
  const isReplaced = (cluster) => clusters.groups[cluster] === NONE || replaced[clusters.groups[cluster]] === 1;
  // The order is that of `coarseGroups`, so groups above come first.
  for (const group of coarse) {
    if (isComplete(group) && entriesOf(results, group).every(isReplaced)) replaced[group] = 1;
  }
  return replaced;
}

/** Returns whether a cluster is drawn: the group it comes from is fine enough, and the group it belongs to is not. */
export function isDrawn({ clusters }, replaced, cluster) {
  const [source, group] = [clusters.sources[cluster], clusters.groups[cluster]];
  return (source === NONE || !replaced[source]) && (group === NONE || replaced[group] === 1);
}

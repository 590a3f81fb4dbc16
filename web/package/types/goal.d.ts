// What `neuralSimplify` and `simplifyModifier` take alike.

import type { Control } from './index.js';

/** How far a mesh is simplified. Give `ratio` or `faces`, `error`, or one of both and `error`. */
export interface Goal extends Control {
  /** Share of the triangles, from 0 to 1. Default: 0 where `error` is given. */
  ratio?: number;
  /** Number of triangles. */
  faces?: number;
  /** Largest error as a share of the extent, the longest side of the bounding box: 0.01 is one percent. Default: any. */
  error?: number;
  /** Whether the boundary stays as it is. Default: false. */
  lockBorder?: boolean;
  /**
   * Whether vertices move, and normals, tangents, texture coordinates, colours and morph targets with them; joints, weights and other
   * attributes are those of the nearest vertex. Without it, vertices of the result are some of the given ones, with the same numbers, and
   * the result lies farther from the original; a material that comes to a vertex of another one has a copy of it, with the normal, texture
   * coordinates and colour of its own nearest vertex. Default: true.
   */
  move?: boolean;
  /** Is called with the share of the work that is done, from 0 to 1. */
  progress?: (share: number) => void;
}

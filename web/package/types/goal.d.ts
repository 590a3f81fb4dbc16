// Options that `neuralSimplify` and `simplifyModifier` share.

import type { Control } from './index.js';

/** Size or error of the result: `ratio` or `faces`, or `error`, or one of the former together with `error`. */
export interface Goal extends Control {
  /** Share of the triangles, from 0 to 1. Default: 0 with `error`. */
  ratio?: number;
  /** Number of triangles. */
  faces?: number;
  /** Largest error as a share of the longest side of the bounding box: 0.01 is one percent. Default: unlimited. */
  error?: number;
  /** Whether the boundary stays unchanged. Default: false. */
  lockBorder?: boolean;
  /**
   * Whether vertices may move to new positions, which keeps the result closer to the original. Default: true.
   *
   * Normals, tangents, texture coordinates, colours and morph targets are adjusted; joints, weights and other attributes come from the
   * closest vertex. With false, all vertices and their values are from the input. At a vertex where a material has none of its own, it
   * gets a copy with the normal, texture coordinates and colour of its closest vertex.
   */
  move?: boolean;
  /** Called with the share of the work that is done, from 0 to 1. */
  progress?: (share: number) => void;
}

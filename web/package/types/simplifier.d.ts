// The types of `neural-mesh/simplifier`: the members of meshoptimizer's `MeshoptSimplifier`, and an asynchronous version.

import type { ProgressControl } from './index.js';

export { NeuralMeshError } from './index.js';

export type SimplifierFlag =
  | 'LockBorder' | 'Sparse' | 'ErrorAbsolute' | 'Prune'
  | 'Regularize' | 'Permissive' | 'RegularizeLight' | 'PreserveFolds' | 'ErrorClamped';

/** Vertex indices, three per triangle; results have the same class. */
export type Indices = Uint32Array | Int32Array | Uint16Array | Int16Array;

/**
 * A simplifier with the members of `MeshoptSimplifier`. All are synchronous and throw before `ready`. Strides count numbers, not bytes.
 *
 * Errors are shares of the mesh's extent, the longest side of its bounding box, or in its unit with the flag `ErrorAbsolute`. They are
 * estimates of the largest distance, made on the way; `simplifyIndices` also measures it.
 *
 * Members throw a `TypeError` that names an invalid argument, and a `NeuralMeshError` if the program fails.
 */
export const NeuralSimplifier: {
  /** Whether WebAssembly is available. */
  readonly supported: boolean;
  /** Resolves when the other members can be called; the first access starts unpacking. */
  readonly ready: Promise<void>;

  /**
   * Renumbers vertices in the order of their first use, and writes the new numbers into `indices`.
   *
   * @returns the new number of each vertex, 0xffffffff for unused ones, and the number of used vertices
   */
  compactMesh: (indices: Indices) => [Uint32Array, number];

  /** Returns for each vertex the first at the same position. */
  generatePositionRemap: (vertex_positions: Float32Array, vertex_positions_stride: number) => Uint32Array;

  /**
   * Simplifies a mesh without moving vertices.
   *
   * @param indices three per triangle
   * @param vertex_positions rows that begin with x, y, z
   * @param vertex_positions_stride length of a row, at least 3
   * @param target_index_count multiple of 3, at most `indices.length`; the result has about this size if `target_error` allows
   * @param target_error largest error, at least 0
   * @returns the indices and the error of the result
   */
  simplify: <T extends Indices>(
    indices: T,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    target_index_count: number,
    target_error: number,
    flags?: SimplifierFlag[],
  ) => [T, number];

  /**
   * Simplifies a mesh with vertex attributes without moving vertices.
   *
   * Seams stay seams. The error is the largest of the position error and the attribute errors, each times its weight and the extent.
   * Attributes of weight 0 do not count.
   *
   * @param vertex_attributes rows of numbers that begin with those that have weights
   * @param vertex_attributes_stride length of a row
   * @param attribute_weights weight of each attribute, at least 0; at most as many as the stride
   * @param vertex_lock 1 for each vertex that must stay, else 0; or null
   * @returns the indices and the error of the result
   */
  simplifyWithAttributes: <T extends Indices>(
    indices: T,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    vertex_attributes: Float32Array,
    vertex_attributes_stride: number,
    attribute_weights: number[],
    vertex_lock: Uint8Array | null,
    target_index_count: number,
    target_error: number,
    flags?: SimplifierFlag[],
  ) => [T, number];

  /**
   * Simplifies in place: writes the result to the beginning of `indices`, and updates positions and attributes of its vertices.
   *
   * @returns the number of indices and the error of the result
   */
  simplifyWithUpdate: (
    indices: Indices,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    vertex_attributes: Float32Array,
    vertex_attributes_stride: number,
    attribute_weights: number[],
    vertex_lock: Uint8Array | null,
    target_index_count: number,
    target_error: number,
    flags?: SimplifierFlag[],
  ) => [number, number];

  /** Returns the extent of a mesh: the longest side of its bounding box, in its unit. */
  getScale: (vertex_positions: Float32Array, vertex_positions_stride: number) => number;

  /**
   * Simplifies a point cloud to a subset of its points.
   *
   * @param vertex_colors rows that begin with red, green, blue
   * @param color_weight weight of colour differences relative to distances; default: 0
   * @returns the indices of the chosen points
   */
  simplifyPoints: (
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    target_vertex_count: number,
    vertex_colors?: Float32Array,
    vertex_colors_stride?: number,
    color_weight?: number,
  ) => Uint32Array;

  /**
   * Simplifies a mesh to a size that topology does not limit: vertices of one cell of a grid become one, and components join.
   *
   * @param vertex_lock 1 for each vertex that must stay, else 0; or null
   * @returns the indices and the longest way of a vertex; the mesh itself, if that is above `target_error`; no indices, if the target is below
   *   what the coarsest grid with a triangle leaves
   */
  simplifySloppy: <T extends Indices>(
    indices: T,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    vertex_lock: Uint8Array | null,
    target_index_count: number,
    target_error: number,
  ) => [T, number];

  /** Drops components smaller than `target_error`, and returns the indices of the others. */
  simplifyPrune: <T extends Indices>(
    indices: T,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    target_error: number,
  ) => T;
};

/** A mesh to simplify. */
export interface IndexedSurface<T extends Indices> {
  /** Vertex indices, three per triangle. */
  indices: T;
  /** Rows that begin with x, y, z. */
  positions: Float32Array;
  /** Length of a row of positions. Default: 3. */
  stride?: number;
  /** Rows of numbers that begin with those that have weights. */
  attributes?: Float32Array;
  /** Length of a row of attributes. */
  attributesStride?: number;
  /** Weight of each attribute, at least 0. An attribute of weight 0 is carried only. */
  weights?: number[];
  /** 1 for each vertex that must stay, else 0. */
  locks?: Uint8Array | null;
  /** Group of each triangle, such as its material; each group has its own vertices. Groups stay joined at equal positions. */
  groups?: Uint32Array | null;
}

/** A simplified mesh. */
export interface ChosenTriangles<T extends Indices> {
  /** Vertex indices, three per triangle. */
  indices: T;
  /** Error of the result. */
  error: number;
  /** Group of each triangle; absent without groups. */
  groups?: Uint32Array;
  /** Coordinates of each vertex, n x 3; only with `move`. */
  positions?: Float32Array;
  /** Attributes that have weights, n x the number of weights; only with `move`. */
  attributes?: Float32Array;
}

/**
 * Simplifies a mesh in a worker as `simplifyWithAttributes` does, or with `move` as `simplifyWithUpdate`. The input is unchanged.
 *
 * @param surface the mesh
 * @param goal `target` is a number of indices; `error` a share of the extent, unlimited by default; `move` lets vertices move; with `measure`
 *   the error of the result is not an estimate but the largest distance of samples of both surfaces from each other
 */
export function simplifyIndices<T extends Indices>(
  surface: IndexedSurface<T>,
  goal: { target: number; error?: number; flags?: SimplifierFlag[]; move?: boolean; measure?: boolean } & ProgressControl,
): Promise<ChosenTriangles<T>>;

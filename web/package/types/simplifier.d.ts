// The types of `neural-mesh/simplifier`: the members of meshoptimizer's `MeshoptSimplifier`, and their call in a worker.

import type { ProgressControl } from './index.js';

export { NeuralMeshError } from './index.js';

export type SimplifierFlag =
  | 'LockBorder' | 'Sparse' | 'ErrorAbsolute' | 'Prune'
  | 'Regularize' | 'Permissive' | 'RegularizeLight' | 'PreserveFolds' | 'ErrorClamped';

/** Three per triangle. What is returned is of the same class. */
export type Indices = Uint32Array | Int32Array | Uint16Array | Int16Array;

/**
 * A simplifier with the members of `MeshoptSimplifier`. All are synchronous and throw before `ready`. Strides count numbers, not bytes.
 *
 * Errors are shares of the mesh's extent, the longest side of its bounding box, or in its unit with the flag `ErrorAbsolute`.
 *
 * Members throw a `TypeError` that names the argument where one is out of range, and a `NeuralMeshError` where the program fails.
 */
export const NeuralSimplifier: {
  /** Whether there is WebAssembly here. */
  readonly supported: boolean;
  /** Resolves when the other members can be called; nothing is unpacked before it is first read. */
  readonly ready: Promise<void>;

  /**
   * Numbers vertices in the order of their use, and writes the new numbers into `indices`.
   *
   * @returns the new number of each vertex, 0xffffffff where it is not used, and how many are
   */
  compactMesh: (indices: Indices) => [Uint32Array, number];

  /** Returns for each vertex the first at the same position. */
  generatePositionRemap: (vertex_positions: Float32Array, vertex_positions_stride: number) => Uint32Array;

  /**
   * Chooses triangles over the same vertices.
   *
   * @param indices three per triangle
   * @param vertex_positions rows that begin with x, y, z
   * @param vertex_positions_stride length of a row, at least 3
   * @param target_index_count multiple of 3, at most `indices.length`; a result has about as many where `target_error` allows
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
   * Chooses triangles over vertices with attributes.
   *
   * Seams between different attributes at one position stay seams. The error is the largest of position and of attributes, each times its
   * weight and the extent. An attribute of weight 0 does not count.
   *
   * @param vertex_attributes rows of numbers that begin with those that have weights
   * @param vertex_attributes_stride length of a row
   * @param attribute_weights what each counts, at least 0; no more than the stride
   * @param vertex_lock for each vertex whether it stays (1) or may go (0), or null
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
   * Simplifies in place: writes the result's indices to the beginning of `indices`, and moves positions and attributes of its vertices.
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
   * Chooses points of a cloud.
   *
   * @param vertex_colors rows that begin with red, green, blue
   * @param color_weight what a difference of colours counts against a distance; default: 0
   * @returns the numbers of the points
   */
  simplifyPoints: (
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    target_vertex_count: number,
    vertex_colors?: Float32Array,
    vertex_colors_stride?: number,
    color_weight?: number,
  ) => Uint32Array;

  /** Drops components smaller than `target_error`, and returns the indices of the others. */
  simplifyPrune: <T extends Indices>(
    indices: T,
    vertex_positions: Float32Array,
    vertex_positions_stride: number,
    target_error: number,
  ) => T;
};

/** A surface whose triangles are to be chosen. */
export interface IndexedSurface<T extends Indices> {
  indices: T;
  /** Rows that begin with x, y, z. */
  positions: Float32Array;
  /** Length of a row of positions. Default: 3. */
  stride?: number;
  /** Rows of numbers that begin with those that have weights. */
  attributes?: Float32Array;
  /** Length of a row of attributes. */
  attributesStride?: number;
  /** What each attribute counts, at least 0. One of weight 0 is carried along. */
  weights?: number[];
  /** For each vertex whether it stays. */
  locks?: Uint8Array | null;
  /** For each triangle the group whose vertices it uses, as those of a material. Groups stay joined at equal positions. */
  groups?: Uint32Array | null;
}

/** A surface whose triangles were chosen. */
export interface ChosenTriangles<T extends Indices> {
  /** Three per triangle. */
  indices: T;
  /** The error of the result. */
  error: number;
  /** With groups: that of each triangle. */
  groups?: Uint32Array;
  /** With `move`: x, y, z of each vertex, n x 3. */
  positions?: Float32Array;
  /** With `move`: the attributes that have weights, n x the number of weights. */
  attributes?: Float32Array;
}

/**
 * Does in a worker what `simplifyWithAttributes` does at once, and with `move` what `simplifyWithUpdate` does. The arrays given stay.
 *
 * @param surface triangles and vertices
 * @param goal `target` is a number of indices; `error` a share of the extent, any by default; `move` lets vertices move
 */
export function simplifyIndices<T extends Indices>(
  surface: IndexedSurface<T>,
  goal: { target: number; error?: number; flags?: SimplifierFlag[]; move?: boolean } & ProgressControl,
): Promise<ChosenTriangles<T>>;

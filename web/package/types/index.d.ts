// The types of `neural-mesh`: simplify, compare, look, formats.

/** An error of the program. Its message is one line: what is wrong, where, and what to do. */
export class NeuralMeshError extends Error {
  name: 'NeuralMeshError';
}

/** The bytes of a file. A `File` of a page is a `Blob`. */
export type Bytes = ArrayBuffer | ArrayBufferView | Blob;

/** Files that another names: materials of an OBJ, buffers and images of a glTF. By the names in it, or a list. */
export type Beside = Record<string, Bytes> | Iterable<{ name: string; bytes: Bytes }>;

/** A mesh file with its name, whose extension says the format where the content does not. */
export interface NamedFile {
  name?: string;
  bytes: Bytes;
  beside?: Beside;
}

/** A mesh file: its bytes, or its bytes and its name. */
export type MeshFile = Bytes | NamedFile;

/** Rows of numbers, one behind the other; a plain array is copied. */
export type Numbers<T> = T | ArrayLike<number> & (ArrayBufferView | readonly number[]);

/** A mesh as arrays, for n vertices and m faces. */
export interface MeshArrays {
  /** Coordinates, n x 3; `Float64Array` keeps double precision. */
  positions: Float32Array | Float64Array | readonly number[];
  /** Vertices of each face, m x 3, from 0. */
  faces: Numbers<Uint32Array>;
  /** Texture coordinates, n x 2. Vertices at equal positions with different ones are a seam. */
  uv?: Numbers<Float32Array>;
  /** Normals of length 1, n x 3. */
  normals?: Numbers<Float32Array>;
  /** Red, green, blue, alpha, from 0 to 1, n x 4. */
  colors?: Numbers<Float32Array>;
  /** A number for each face, m: its material, or what else it belongs to. */
  groups?: Numbers<Uint32Array>;
  /** How much a vertex counts, n; 1 is as usual. */
  importance?: Numbers<Float32Array>;
}

/** A lighter mesh as arrays. */
export interface ResultArrays {
  /** n x 3; `Float64Array` where the input was in double precision. */
  positions: Float32Array | Float64Array;
  /** m x 3. */
  faces: Uint32Array;
  /** n x 2. */
  uv?: Float32Array;
  /** n x 3. */
  normals?: Float32Array;
  /** Red, green, blue, alpha, n x 4. */
  colors?: Float32Array;
  /** m. */
  groups?: Uint32Array;
  /** For each vertex the one of the input that it comes from, n; with the option `map`. */
  map?: Uint32Array;
}

/** A number, or text as the program's command line takes it: `0.1`, `'10%'`, `'10k'`. */
export type Amount = number | string;

/**
 * The options of `neural-mesh simplify` by their names, `_` for `-`. Give one size: `ratio`, `vertices`, `faces`, `error`, `size` or
 * `lods`.
 */
export interface SimplifyOptions {
  /** Share of the vertices, between 0 and 1. */
  ratio?: Amount;
  /** Number of vertices, or a share as `'10%'`. */
  vertices?: Amount;
  /** Number of faces, or a share as `'10%'`. */
  faces?: Amount;
  /** Largest distance to the original: in the mesh's unit, or as `'0.5%'` of its diagonal. */
  error?: Amount;
  /** Size of the written file: bytes, `'200kB'`, `'2MB'`. */
  size?: Amount;
  /** Sizes of several levels of detail, the finest first. */
  lods?: Amount[];
  /** What the sizes of `lods` count. */
  lods_by?: string;
  /** Format of the result where no name says it; `formats().write` has all. */
  format?: string;
  /** The figure that goes first. */
  optimize?: 'balanced' | 'mean' | 'max' | 'normals';
  /** Time against distance. */
  effort?: 'fast' | 'standard' | 'best';
  /** Where the mesh has a boundary, it stays as it is. */
  lock_boundaries?: boolean;
  /** The vertices of the result are some of the input's, not moved. */
  subset?: boolean;
  /** No small component is dropped. */
  keep_components?: boolean;
  /** Edges sharper than 30 degrees stay edges. */
  keep_features?: boolean;
  /** Parts of these names stay as they are. */
  keep?: string[];
  /** The results' arrays say where their vertices come from. */
  map?: boolean;
  /** Skips the measurement of the distance. */
  no_check?: boolean;
  /** Seed of all random choices; equal seeds give equal bytes. */
  seed?: number;
  /** Further options of the program. */
  [option: string]: unknown;
}

/** How a call runs. */
export interface Control {
  /** Ends the call: the worker is ended at once and the call rejects with the signal's reason, an `AbortError` by default. */
  signal?: AbortSignal;
  /** `false` runs the call in this thread, which is blocked meanwhile. Where workers are refused, all calls run so. Default: true. */
  worker?: boolean;
}

/** How a long call runs, and who hears of it. */
export interface ProgressControl extends Control {
  /**
   * Is called with the share of a part of the work that is done, from 0 to 1, and the number of the part: 0 reads, 1 simplifies, 2 bakes,
   * 3 measures, 4 writes.
   */
  progress?: (share: number, part: number) => void;
}

export interface SimplifyControl extends ProgressControl {
  /** Name of the input file. Default: that of the `File`, else the content says the format. */
  name?: string;
  /** Files that the input names. */
  beside?: Beside;
  /**
   * Name of the result, whose extension is its format. Default: `name`, with the extension of the option `format`. Levels of detail that
   * are files of their own are named `NAME-1.ply`, `NAME-2.ply`.
   */
  out?: string;
  /** Whether arrays of the results are returned; then a file is written only with `out`. Default: for an input of arrays without `out`. */
  arrays?: boolean;
}

/** A file that was written, and those that it names. */
export interface WrittenFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
  beside: { name: string; bytes: Uint8Array<ArrayBuffer> }[];
}

export interface SimplifyResult {
  /** The bytes of the first file; absent where none was written. */
  bytes?: Uint8Array<ArrayBuffer>;
  /** What was done, as `neural-mesh simplify --report` writes it: sizes, topology, distance, time. */
  report: Record<string, any>;
  /** All files: one, or one for each level of detail. */
  files: WrittenFile[];
  /** The results as arrays, one for each level; empty without `arrays`. */
  results: ResultArrays[];
  /** Lines for people: what was repaired, left out, not reached. */
  notes: string[];
}

/**
 * Makes a mesh lighter.
 *
 * ```js
 * const { bytes, report } = await simplify(file, { ratio: 0.1 });
 * const { results: [light] } = await simplify({ positions, faces }, { faces: 1000 });
 * ```
 *
 * @param input a mesh file, or arrays
 * @throws NeuralMeshError where the file cannot be read, an option is wrong, or memory is short
 * @throws TypeError, RangeError where an argument is of the wrong type or length
 */
export function simplify(input: MeshFile | MeshArrays, options: SimplifyOptions, control?: SimplifyControl): Promise<SimplifyResult>;

/**
 * Measures how meshes of any program differ from their original.
 *
 * @param original a mesh file
 * @param results one mesh file, or several
 * @throws NeuralMeshError where a file cannot be read
 */
export function compare(
  original: MeshFile,
  results: MeshFile | MeshFile[],
  control?: ProgressControl & {
    /** Points that are measured on each surface. Default: that of the program. */
    samples?: number;
  },
): Promise<{
  /** What `neural-mesh compare --json` writes. */
  comparison: any;
  /** The surfaces that were measured, the original first: n x 3, m x 3, and into how many steps each side of a face is divided. */
  surfaces: { positions: Float32Array; faces: Uint32Array; steps: number }[];
  /** For each result, the distances of the points of its surface to the original, and of the original's to it, in the mesh's unit. */
  distances: { of_result: Float32Array; of_original: Float32Array }[];
}>;

/** A surface to draw: all meshes of a scene where a viewer sees them, vertices split at seams. */
export interface LookMesh {
  /** n x 3, from `origin`. */
  positions: Float32Array;
  /** Point that is added to all positions. */
  origin: [number, number, number];
  /** m x 3, in the order of `groups`. */
  faces: Uint32Array;
  /** n x 3. */
  normals?: Float32Array;
  /** n x 2. */
  uv?: Float32Array;
  /** n x 4, from 0 to 1. */
  colors?: Float32Array;
  /** Runs of faces that look alike. */
  groups: LookGroup[];
}

/** Faces of one colour and one image. */
export interface LookGroup {
  /** First face. */
  from: number;
  /** Number of faces. */
  faces: number;
  /** Red, green, blue, alpha, from 0 to 1. */
  color: [number, number, number, number];
  /** A PNG, JPEG or WebP file. */
  image?: Uint8Array<ArrayBuffer>;
}

/**
 * Reads a mesh file as one surface to draw.
 *
 * @throws NeuralMeshError where the file cannot be read
 */
export function look(
  input: MeshFile,
  control?: Control & { name?: string; beside?: Beside },
): Promise<{ mesh: LookMesh; notes: string[] }>;

/** Lists the formats that are read and written, as extensions of file names. */
export function formats(control?: Control): Promise<{ read: string[]; write: string[]; version: string }>;

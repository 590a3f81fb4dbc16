// The types of `neural-mesh`: simplify, compare, look, formats.

/** An error of the program; its message is one line that says what is wrong, where, and what to do. */
export class NeuralMeshError extends Error {
  name: 'NeuralMeshError';
}

/** Bytes of a file; a browser's `File` is a `Blob`. */
export type Bytes = ArrayBuffer | ArrayBufferView | Blob;

/** Files that a mesh file refers to, such as materials and images: an object by the names in the mesh file, or a list. */
export type Beside = Record<string, Bytes> | Iterable<{ name: string; bytes: Bytes }>;

/** A mesh file with a name; its extension gives the format if the content does not. */
export interface NamedFile {
  name?: string;
  bytes: Bytes;
  beside?: Beside;
}

/** A mesh file: its bytes, or its bytes and its name. */
export type MeshFile = Bytes | NamedFile;

/** Rows of numbers in one flat array; a plain array is copied. */
export type Numbers<T> = T | ArrayLike<number> & (ArrayBufferView | readonly number[]);

/** A mesh of n vertices and m faces as flat arrays. */
export interface MeshArrays {
  /** Coordinates, n x 3; `Float64Array` keeps double precision. */
  positions: Float32Array | Float64Array | readonly number[];
  /** Vertices of each face, m x 3, from 0. */
  faces: Numbers<Uint32Array>;
  /** Texture coordinates, n x 2. Vertices at equal positions with different coordinates form a seam. */
  uv?: Numbers<Float32Array>;
  /** Normals of length 1, n x 3. */
  normals?: Numbers<Float32Array>;
  /** Red, green, blue, alpha, from 0 to 1, n x 4. */
  colors?: Numbers<Float32Array>;
  /** Group of each face, such as its material, m. Borders between groups stay. */
  groups?: Numbers<Uint32Array>;
  /** Importance of each vertex, n, at least 0; 1 is neutral. */
  importance?: Numbers<Float32Array>;
}

/** A simplified mesh of n vertices and m faces as flat arrays. */
export interface ResultArrays {
  /** Coordinates, n x 3; `Float64Array` for input in double precision. */
  positions: Float32Array | Float64Array;
  /** Vertices of each face, m x 3. */
  faces: Uint32Array;
  /** Texture coordinates, n x 2. */
  uv?: Float32Array;
  /** Normals of length 1, n x 3. */
  normals?: Float32Array;
  /** Red, green, blue, alpha, from 0 to 1, n x 4. */
  colors?: Float32Array;
  /** Group of each face, m. */
  groups?: Uint32Array;
  /** Input vertex of each vertex, n; only with the option `map`. */
  map?: Uint32Array;
}

/** A number, or a string as on the program's command line: `0.1`, `'10%'`, `'10k'`. */
export type Amount = number | string;

/**
 * Options of `neural-mesh simplify`, with `_` for `-` in names. Exactly one size is given: `ratio`, `vertices`, `faces`, `error`, `size`
 * or `lods`.
 */
export interface SimplifyOptions {
  /** Share of the vertices, between 0 and 1. */
  ratio?: Amount;
  /** Number of vertices, or a share as `'10%'`. */
  vertices?: Amount;
  /** Number of faces, or a share as `'10%'`. */
  faces?: Amount;
  /** Largest distance to the original, in the mesh's unit, or as `'0.5%'` of the diagonal of its bounding box. */
  error?: Amount;
  /** Size of the written file: bytes, `'200kB'`, `'2MB'`. */
  size?: Amount;
  /** Sizes of several levels of detail, the finest first. */
  lods?: Amount[];
  /** Kind of the sizes in `lods`: `'vertices'` (the default), `'faces'` or `'error'`. */
  lods_by?: string;
  /** Format of the result if no file name gives it; `formats().write` lists all. */
  format?: string;
  /** Figure to favor. */
  optimize?: 'balanced' | 'mean' | 'max' | 'normals' | 'looks';
  /** Time against quality. */
  effort?: 'fast' | 'standard' | 'best';
  /** Keeps boundaries unchanged. */
  lock_boundaries?: boolean;
  /** Keeps vertices of the input, at their exact positions. */
  subset?: boolean;
  /** Keeps all components. */
  keep_components?: boolean;
  /** Keeps edges where the surface bends by more than 30 degrees. */
  keep_features?: boolean;
  /** Names whose faces stay unchanged. */
  keep?: string[];
  /** Adds the input vertex of each vertex to the results' arrays. */
  map?: boolean;
  /** Skips the measurement of the distance. */
  no_check?: boolean;
  /** Seed of all random choices; equal seeds give equal bytes. */
  seed?: number;
  /** Further options of the program. */
  [option: string]: unknown;
}

/** Cancellation and threading of a call. */
export interface Control {
  /** Aborts the call: terminates the worker and rejects with the signal's reason, an `AbortError` by default. */
  signal?: AbortSignal;
  /** `false` runs the call in this thread and blocks it; so do all calls if workers are not allowed. Default: true. */
  worker?: boolean;
}

/** Cancellation, threading and progress of a long call. */
export interface ProgressControl extends Control {
  /**
   * Called with the share of the current stage that is done, from 0 to 1, and the number of the stage: 0 reads, 1 simplifies, 2 bakes,
   * 3 measures, 4 writes.
   */
  progress?: (share: number, part: number) => void;
}

export interface SimplifyControl extends ProgressControl {
  /** Name of the input file. Default: that of the `File`; without a name the content decides the format. */
  name?: string;
  /** Files that the input refers to. */
  beside?: Beside;
  /**
   * Name of the result, whose extension is its format. Default: `name`, with the extension of the option `format`. Levels of detail in
   * separate files are named `NAME-1.ply`, `NAME-2.ply`.
   */
  out?: string;
  /** Whether results are returned as arrays; then a file is written only with `out`. Default: true for arrays without `out`. */
  arrays?: boolean;
}

/** A written file with the files that it refers to. */
export interface WrittenFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
  beside: { name: string; bytes: Uint8Array<ArrayBuffer> }[];
}

export interface SimplifyResult {
  /** Bytes of the first file; absent if none was written. */
  bytes?: Uint8Array<ArrayBuffer>;
  /** Report as `neural-mesh simplify --report` writes it: sizes, topology, distance, time. */
  report: Record<string, any>;
  /** All files: one, or one per level of detail. */
  files: WrittenFile[];
  /** Results as arrays, one per level of detail; empty without `arrays`. */
  results: ResultArrays[];
  /** Lines for the user about repairs, omissions and missed sizes. */
  notes: string[];
}

/**
 * Simplifies a mesh to a given size.
 *
 * ```js
 * const { bytes, report } = await simplify(file, { ratio: 0.1 });
 * const { results: [light] } = await simplify({ positions, faces }, { faces: 1000 });
 * ```
 *
 * @param input a mesh file, or arrays
 * @throws NeuralMeshError if the file cannot be read, an option is wrong, or memory runs out
 * @throws TypeError, RangeError if an argument has the wrong type or length
 */
export function simplify(input: MeshFile | MeshArrays, options: SimplifyOptions, control?: SimplifyControl): Promise<SimplifyResult>;

/**
 * Measures how simplified meshes differ from their original.
 *
 * @param original a mesh file
 * @param results one mesh file, or several; any program may have made them
 * @throws NeuralMeshError if a file cannot be read
 */
export function compare(
  original: MeshFile,
  results: MeshFile | MeshFile[],
  control?: ProgressControl & {
    /** Sample points per surface. Default: that of the program. */
    samples?: number;
  },
): Promise<{
  /** Figures as `neural-mesh compare --json` writes them. */
  comparison: any;
  /** Measured surfaces, the original first: n x 3, m x 3, and the number of steps along each side of a face between measured points. */
  surfaces: { positions: Float32Array; faces: Uint32Array; steps: number }[];
  /** Distances for each result: from points of its surface to the original, and from the original's to it, in the mesh's unit. */
  distances: { of_result: Float32Array; of_original: Float32Array }[];
}>;

/** A surface to draw: all meshes of a scene in place, with vertices split at seams. */
export interface LookMesh {
  /** Coordinates relative to `origin`, n x 3. */
  positions: Float32Array;
  /** Offset of all positions. */
  origin: [number, number, number];
  /** Vertices of each face, m x 3, in the order of `groups`. */
  faces: Uint32Array;
  /** Normals of length 1, n x 3. */
  normals?: Float32Array;
  /** Texture coordinates, n x 2. */
  uv?: Float32Array;
  /** Red, green, blue, alpha, from 0 to 1, n x 4. */
  colors?: Float32Array;
  /** Ranges of faces with one colour and one image. */
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
 * @throws NeuralMeshError if the file cannot be read
 */
export function look(
  input: MeshFile,
  control?: Control & { name?: string; beside?: Beside },
): Promise<{ mesh: LookMesh; notes: string[] }>;

/** Lists the formats that are read and written, as extensions of file names. */
export function formats(control?: Control): Promise<{ read: string[]; write: string[]; version: string }>;

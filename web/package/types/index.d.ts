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
  // made from the list of options: start
  /** Share of the vertices to keep: 0.1 or 10%. */
  ratio?: Amount;
  /** Number of faces to keep: 5000, 10k, 1.5M or 10%. */
  faces?: Amount;
  /** Number of vertices to keep: 5000, 10k, 1.5M or 10%. */
  vertices?: Amount;
  /** Largest distance to the original, in units of the mesh or with % of its diagonal; finds the smallest mesh. */
  error?: Amount;
  /** Largest file size, such as 500kB or 2MB; finds the largest mesh that fits. */
  size?: Amount;
  /** Levels of detail as falling shares of the vertices, such as 50%,25%,10%. */
  lods?: Amount[];
  /** Unit of lods: vertices or faces, as shares or as numbers such as 20k,5k, or proved largest distances such as 0.1%,0.5% [default: vertices]. */
  lods_by?: 'vertices' | 'faces' | 'error';
  /** Convention for names and files of lods: NAME_LOD0 nodes in one glTF (unity, godot), a file per level (unreal), or MSFT_lod (gltf). */
  engine?: 'unity' | 'unreal' | 'godot' | 'gltf';
  /** Vertical field of view for the distances from which levels of lods are drawn, above 0 and below 180 degrees [default: 60]. */
  field_of_view?: number;
  /** Format of the result if the name of OUT has no known ending: obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb. */
  format?: string;
  /** Property that the result must preserve best [default: shape]. */
  for?: 'shape' | 'poses';
  /** Keep edges where the surface bends by more than 30 degrees. */
  keep_features?: boolean;
  /** Keep edges where the surface bends by more than DEGREES. */
  crease_angle?: number;
  /** Keep the boundary exactly, so that neighbouring tiles still fit. */
  lock_boundaries?: boolean;
  /** Keep all components, even if their vertices would reduce the distance more elsewhere. */
  keep_components?: boolean;
  /** Keep a node, mesh, object, group or material unchanged; may be repeated. */
  keep?: string[];
  /** Do not move vertices: the result uses vertices of the input. */
  subset?: boolean;
  /** Discard attributes (uv, normals, colors, materials), so that their seams and borders do not limit the result. */
  ignore?: ('uv' | 'normals' | 'colors' | 'materials')[];
  /** Distance that texture seams may move, in texels of the largest colour texture [default: 1/64 of its side]. */
  seam_error?: number;
  /** Weights of vertices: the name of a numeric vertex attribute, or NAME=FACTOR for the faces of a node, mesh, material, group or object. Larger weights keep more vertices; all other faces have weight 1. */
  importance?: string;
  /** Drop components smaller than SIZE, in units of the mesh or with % of its diagonal; without SIZE, smaller than the bound of error. Dropped components do not count for the bound. */
  prune?: boolean | Amount;
  /** Keep the shape of components, within DISTANCE in units of the mesh or with % of its diagonal [default: 1%]. Sizes that need more are then not reached. */
  hold_shape?: boolean | Amount;
  /** Treatment of surfaces that are invisible from outside [default: keep]. */
  hidden?: 'keep' | 'drop';
  /** Close holes with at most EDGES boundary edges [default: all holes]. */
  fill_holes?: boolean | number;
  /** Make a printable solid; drops components smaller than SIZE [default: 1%]. */
  printable?: boolean | Amount;
  /** Merge vertices closer than DISTANCE, in units of the mesh or with % of its diagonal. */
  weld?: Amount;
  /** Do not merge vertices at equal positions. */
  no_weld?: boolean;
  /** Write a compressed glTF, as gltfpack does; `quantize` only quantises it. */
  compress?: boolean | 'meshopt' | 'quantize';
  /** Shrink textures whose longer side exceeds SIZE texels; others stay unchanged. */
  textures?: number;
  /** Also read materials and textures that lie outside the folder of the mesh. */
  allow_outside?: boolean;
  /** Measure to favour: mean distance, largest distance, normals (shading), or appearance [default: balanced]. */
  optimize?: 'balanced' | 'mean' | 'max' | 'normals' | 'looks';
  /** Time to spend: more time, smaller distance to the original [default: standard]. */
  effort?: 'fast' | 'standard' | 'best';
  /** Source of the scores, which say where vertices are needed [default: bending]. */
  scores?: 'bending' | 'network' | 'geometry';
  /** Method that builds the surface [default: closed]. */
  assembly?: 'closed' | 'paper';
  /** With assembly paper: way of drawing the vertices by their scores [default: scattered]. */
  draw?: 'scattered' | 'multinomial';
  /** With assembly paper: close the holes of the result. */
  close?: boolean;
  /** With assembly paper: sample again, denser where the error is large, and move vertices to reduce the error. */
  place?: boolean;
  /** Seed of the sampling of assembly paper; equal seeds give equal meshes [default: 0]. */
  seed?: number;
  /** Do not measure the distance of the result to the original. */
  no_check?: boolean;
  // made from the list of options: end
  /** Shares of the vertices by the name of a node, mesh, object, group or material. */
  ratio_of?: Record<string, Amount>;
  /** Adds the input vertex of each vertex to the results' arrays. */
  map?: boolean;
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
  /** Direction toward the eye that shows the most telling side, if y is up. */
  eye: [number, number, number];
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
  /** Absent if the material is only a colour. */
  finish?: Finish;
}

/** How a material treats light, as glTF defines it. */
export interface Finish {
  /** Emitted red, green, blue, from 0 to 1. */
  emission: [number, number, number];
  /** From 0 to 1. */
  roughness: number;
  /** From 0 to 1. */
  metal: number;
  /** Factor of the normal map. */
  normalScale: number;
  /** Strength of the occlusion, from 0 to 1. */
  occlusion: number;
  /** PNG, JPEG or WebP files on the texture coordinates of the image; roughness in green, metal in blue, occlusion in red. */
  maps: { [name in 'normal' | 'emission' | 'roughness' | 'metal' | 'occlusion']?: Uint8Array<ArrayBuffer> };
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

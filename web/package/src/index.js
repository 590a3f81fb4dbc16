// Exports the program: simplification of files and arrays, comparison, and surfaces to draw. See `types/index.d.ts`.

import { checkNames } from './names.js';
import { isArrays, readArrays, readFile } from './input.js';
import { makeProgram } from './runtime.js';
import { packRows, unpackRows } from './strided.js';
import packed from 'packed:everything';
import workerText from 'packed:worker';

export { NeuralMeshError } from './runtime.js';

const program = makeProgram(packed, workerText);

/** Names in the third argument of `simplify`. */
const FILES = ['name', 'beside', 'out', 'arrays', 'progress', 'signal', 'worker'];

/** Throws a TypeError for options that are none, or that belong to the third argument. */
function checkOptions(options) {
  if (typeof options !== 'object' || options === null) throw new TypeError(`options: ${options} is not an object: give { ratio: 0.1 }`);
  const file = FILES.find((name) => name in options);
  if (file) throw new TypeError(`${file}: give it in the third argument: simplify(mesh, { ratio: 0.1 }, { ${file}: ... })`);
}

/** Simplifies a mesh file or arrays. */
export async function simplify(input, options = {}, files = {}) {
  checkOptions(options);
  checkNames(files, FILES);
  const { name, beside, out, arrays, progress, signal, worker } = files;
  const fromArrays = isArrays(input);
  const source = fromArrays ? { mesh: readArrays(input) } : { file: await readFile(input, name, beside) };
  const wantsArrays = arrays ?? (fromArrays && out === undefined);
  const writtenAs = out ?? (wantsArrays ? undefined : defaultName(source.file?.name ?? 'mesh', options.format));
  const request = { call: 'simplify', options, ...source, out: writtenAs, arrays: wantsArrays };
  const answer = await program.call(request, { progress, signal, worker });
  const written = answer.json.files.map((file) => writtenFile(file, answer));
  const results = answer.json.results.map((result) => meshArrays(result, answer));
  return { bytes: written[0]?.bytes, report: answer.json.report, files: written, results, notes: answer.json.notes };
}

/** Returns the name of a result: the input's, with the extension of the chosen format. */
function defaultName(name, format) {
  if (!format && !name.includes('.')) {
    throw new TypeError("the format is not known: give the name of the file in the third argument, { name: 'mesh.obj' }, or of the result, { out: 'mesh.glb' }");
  }
  return format ? `${name.replace(/(\.[^./]*)?(\.gz)?$/, '')}.${format}` : name;
}

/** Measures how meshes differ from their original. */
export async function compare(original, results, { samples, progress, signal, worker } = {}) {
  const request = {
    call: 'compare',
    original: await readFile(original),
    results: await Promise.all([results].flat().map((result) => readFile(result))),
    samples,
  };
  const { json, array } = await program.call(request, { progress, signal, worker });
  const surfaces = json.surfaces.map(({ positions, faces, steps }) => (
    { positions: array(positions, Float32Array), faces: array(faces, Uint32Array), steps }));
  const distances = json.distances.map(({ of_result, of_original }) => (
    { of_result: array(of_result, Float32Array), of_original: array(of_original, Float32Array) }));
  return { comparison: json.comparison, surfaces, distances };
}

/** Reads a mesh file as one surface to draw. */
export async function look(input, { name, beside, signal, worker } = {}) {
  const answer = await program.call({ call: 'look', file: await readFile(input, name, beside) }, { signal, worker });
  const { mesh, notes } = answer.json;
  const arrays = meshArrays({ ...mesh, colors_width: 4, groups: undefined }, answer);
  const images = new Map();
  const imageOf = (number) => {
    if (!images.has(number)) images.set(number, answer.array(number));
    return images.get(number);
  };
  const groups = mesh.groups.map(({ image, finish, ...group }) => {
    const maps = Object.entries(finish?.maps ?? {}).map(([kind, number]) => [kind, imageOf(number)]);
    return {
      ...group, ...(Number.isInteger(image) && { image: imageOf(image) }), ...(finish && { finish: { ...finish, maps: Object.fromEntries(maps) } }),
    };
  });
  return { mesh: { ...arrays, origin: mesh.origin, eye: mesh.eye, groups }, notes };
}

/** Lists the formats that are read and written. */
export async function formats({ signal, worker } = {}) {
  return (await program.call({ call: 'formats' }, { signal, worker })).json;
}

/** Returns a written file with its bytes and the files it refers to; names like `ply-ascii` become `ply`. */
function writtenFile({ name, bytes, beside }, { array }) {
  const others = beside.map((file) => ({ name: file.name, bytes: array(file.bytes) }));
  return { name: name.replace(/-ascii$/, ''), bytes: array(bytes), beside: others };
}

/** Reads the arrays of a mesh from an answer; arrays that the mesh lacks are absent. */
function meshArrays({ positions, doubles, faces, uv, uv_width = 2, normals, colors, colors_width, groups, map }, { array }) {
  const mesh = { positions: array(positions, doubles ? Float64Array : Float32Array), faces: array(faces, Uint32Array) };
  if (uv) mesh.uv = packRows(array(uv, Float32Array), uv_width, 2);
  if (normals) mesh.normals = array(normals, Float32Array);
  if (colors) mesh.colors = withAlpha(array(colors, Float32Array), colors_width);
  if (groups) mesh.groups = array(groups, Uint32Array);
  if (map) mesh.map = array(map, Uint32Array);
  return mesh;
}

/** Returns RGBA colours; colours without alpha become opaque. */
function withAlpha(colors, width) {
  if (width === 4) return colors;
  const wide = new Float32Array((4 * colors.length) / width).fill(1);
  unpackRows(colors, wide, 4, width);
  return wide;
}

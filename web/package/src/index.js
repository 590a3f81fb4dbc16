// The whole program: files and arrays in, lighter files and arrays out; comparison; surfaces to draw. `types/index.d.ts` documents it.

import { isArrays, readArrays, readFile } from './input.js';
import { makeProgram } from './runtime.js';
import packed from 'packed:everything';
import workerText from 'packed:worker';

export { NeuralMeshError } from './runtime.js';

const program = makeProgram(packed, workerText);

/** Makes a mesh lighter. */
export async function simplify(input, options = {}, { name, beside, out, arrays, progress, signal, worker } = {}) {
  const fromArrays = isArrays(input);
  const source = fromArrays ? { mesh: readArrays(input) } : { file: await readFile(input, name, beside) };
  const wantsArrays = arrays ?? (fromArrays && out === undefined);
  const written = out ?? (fromArrays || wantsArrays || options.format ? undefined : source.file.name);
  const request = { call: 'simplify', options, ...source, out: written, arrays: wantsArrays };
  const answer = await program.call(request, { progress, signal, worker });
  const files = (answer.json.files ?? []).map((file) => writtenFile(file, answer));
  const results = answer.json.results?.map((result) => meshArrays(result, answer)) ?? [];
  return { bytes: files[0]?.bytes, report: answer.json.report, files, results, notes: answer.json.notes ?? [] };
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
  const distances = (json.distances ?? []).map((each) => ({
    of_result: array(each.of_result, Float32Array),
    of_original: array(each.of_original, Float32Array),
  }));
  return { comparison: json.comparison, distances };
}

/** Reads a mesh file as one surface to draw. */
export async function look(input, { name, beside, signal, worker } = {}) {
  const answer = await program.call({ call: 'look', file: await readFile(input, name, beside) }, { signal, worker });
  const { mesh, notes = [] } = answer.json;
  const groups = mesh.groups?.map((group) => withArrays(group, { image: Uint8Array }, answer));
  return { mesh: { ...meshArrays({ ...mesh, groups: undefined }, answer), groups: groups ?? [] }, notes };
}

/** Lists the formats that are read and written. */
export async function formats({ signal, worker } = {}) {
  return (await program.call({ call: 'formats' }, { signal, worker })).json;
}

function writtenFile({ name, bytes, beside = [] }, answer) {
  return { name, bytes: answer.array(bytes), beside: beside.map((file) => ({ name: file.name, bytes: answer.array(file.bytes) })) };
}

/** The arrays of a mesh in place of their numbers. */
function meshArrays({ doubles, ...mesh }, answer) {
  const types = {
    positions: doubles ? Float64Array : Float32Array,
    faces: Uint32Array, uv: Float32Array, normals: Float32Array, colors: Float32Array, groups: Uint32Array, map: Uint32Array,
  };
  return withArrays(mesh, types, answer);
}

function withArrays(object, types, { array }) {
  const read = ([name, value]) => [name, types[name] && Number.isInteger(value) ? array(value, types[name]) : value];
  return Object.fromEntries(Object.entries(object).filter(([, value]) => value !== null && value !== undefined).map(read));
}

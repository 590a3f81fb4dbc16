// Converts the caller's mesh for the program: a file with the files it refers to, or arrays.

/** Arrays of a mesh by name, with their class and their length per vertex or face. */
const LAYERS = {
  uv: [Float32Array, 2, 'vertex'],
  normals: [Float32Array, 3, 'vertex'],
  colors: [Float32Array, 4, 'vertex'],
  groups: [Uint32Array, 1, 'face'],
  importance: [Float32Array, 1, 'vertex'],
};

/** Returns whether an input is a mesh as arrays, and not a file. */
export function isArrays(input) {
  return ArrayBuffer.isView(input?.positions) || Array.isArray(input?.positions);
}

/**
 * Reads a file: bytes, a `Blob` or `File`, or an object with `bytes`, `name` and `beside`.
 *
 * @param {string} [name] name that overrides the file's own
 * @param {object | Iterable} [beside] files that it refers to: bytes by name, or a list of `{name, bytes}`
 */
export async function readFile(input, name = input?.name, beside = input?.beside) {
  // A `Blob` has a method named `bytes`.
  const isNamed = input?.bytes !== undefined && typeof input.bytes !== 'function';
  const bytes = await readBytes(isNamed ? input.bytes : input);
  const others = beside && Symbol.iterator in beside ? [...beside].map((file) => [file.name, file.bytes]) : Object.entries(beside ?? {});
  const read = await Promise.all(others.map(async ([path, content]) => [path, await readBytes(content)]));
  return { name: name ?? nameByContent(bytes), bytes, beside: Object.fromEntries(read) };
}

/** Checks the arrays of a mesh and converts them to the classes that the program takes. */
export function readArrays(input) {
  if (input.faces === undefined && input.indices !== undefined) throw new TypeError('indices: name them faces: { positions, faces: indices }');
  const doubles = input.positions instanceof Float64Array;
  const mesh = {
    positions: arrayOf(input.positions, doubles ? Float64Array : Float32Array, 'positions'),
    doubles,
    faces: arrayOf(input.faces, Uint32Array, 'faces'),
  };
  const counts = { vertex: rows(mesh.positions, 3, 'positions'), face: rows(mesh.faces, 3, 'faces') };
  for (const [name, [type, width, per]] of Object.entries(LAYERS)) {
    if (input[name] === undefined || input[name] === null) continue;
    mesh[name] = arrayOf(input[name], type, name);
    if (mesh[name].length !== width * counts[per]) {
      throw new RangeError(`${name}: ${mesh[name].length} numbers: give ${width} for each ${per}, ${width * counts[per]}`);
    }
  }
  return mesh;
}

function rows(array, width, name) {
  if (array.length % width !== 0) throw new RangeError(`${name}: ${array.length} numbers are not a multiple of ${width}`);
  return array.length / width;
}

function arrayOf(values, type, name) {
  if (values instanceof type) return values;
  if (!Array.isArray(values) && (!ArrayBuffer.isView(values) || values instanceof DataView)) {
    throw new TypeError(`${name}: give a ${type.name}`);
  }
  if (ArrayBuffer.isView(values[0]) || Array.isArray(values[0])) throw new TypeError(`${name}: give one list of numbers: ${name}.flat()`);
  return type.from(values);
}

async function readBytes(content) {
  if (typeof content === 'string') {
    throw new TypeError(`${content.slice(0, 80)}: no file or address is opened: give the bytes, such as await fetch(url) or await readFile(path)`);
  }
  if (content instanceof ArrayBuffer) return new Uint8Array(content);
  if (ArrayBuffer.isView(content)) return new Uint8Array(content.buffer, content.byteOffset, content.byteLength);
  if (typeof content?.arrayBuffer === 'function') return new Uint8Array(await content.arrayBuffer());
  throw new TypeError('give a mesh as Uint8Array, ArrayBuffer, Blob, File, {name, bytes} or {positions, faces}');
}

/** Returns a name for bytes without one; the program then detects the format from the content. */
function nameByContent(bytes) {
  return { glTF: 'mesh.glb', 'ply\n': 'mesh.ply' }[new TextDecoder('latin1').decode(bytes.subarray(0, 4))] ?? 'mesh';
}

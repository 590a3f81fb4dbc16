// Reads `.nmp` files, which docs/progression.md describes. No byte is trusted.

import { inSlices } from '../slices.js';
import { checksumOf } from './checksum.js';

const VERSION = 2;
const MAGIC = 'NMESHPRG';
const HEAD = 12;
/** Bytes of a merge, and of a dropped component. */
const MERGE = 21;
const DROPPED = 12;

/**
 * Reads a file, a blob: positions and faces of the mesh; `surface`, faces and copied vertices, if the merges are of a mesh that was
 * split to become manifold; the merges; `size`, the numbers of vertices and faces that shares refer to; dropped components; proved
 * levels; `sceneDiagonal`, of the box of a scene, else null; `hasNormals`.
 */
export async function readProgression(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  await checkEnds(bytes);
  const reader = { bytes, view: new DataView(bytes.buffer), at: HEAD, end: bytes.length - 8 };
  const [positions, faces] = [floatRows(reader, 3), wordRows(reader, 3)];
  const hasNormals = skipAttributes(reader);
  const sceneDiagonal = skipScene(reader);
  skipOptions(reader);
  const size = [length(reader), length(reader)];
  for (let origin = 0; origin < 2; origin++) skipOrigin(reader);
  const surface = { faces: optional(reader, () => wordRows(reader, 3)), copies: wordRows(reader, 1) };
  const merges = await readMerges(reader);
  const drops = list(reader, 24, () => readDrop(reader));
  const proofs = list(reader, 16, () => ({ nVertices: length(reader), distance: float(reader) }));
  check(proofs.every(({ nVertices, distance }) => nVertices > 0 && distance >= 0), 'a proved level without a distance');
  // The files of the input follow, which nothing here needs.
  check(positions.every(Number.isFinite), 'a position that is not finite');
  checkFaces(faces, positions.length / 3);
  return { positions, faces, surface: readSurface(surface, positions, faces), merges, size, drops, proofs, sceneDiagonal, hasNormals };
}

async function checkEnds(bytes) {
  if (String.fromCharCode(...bytes.subarray(0, 8)) !== MAGIC) throw new Error(`no progression: the first bytes are not "${MAGIC}"`);
  check(bytes.length >= HEAD + 8, 'the file is cut off');
  const view = new DataView(bytes.buffer);
  const version = view.getUint32(8, true);
  if (version !== VERSION) throw new Error(`version ${version} of the format, but ${VERSION} is read here: make the file again`);
  const [low, high] = await checksumOf(bytes.subarray(0, bytes.length - 8));
  const isSame = view.getUint32(bytes.length - 8, true) === low && view.getUint32(bytes.length - 4, true) === high;
  check(isSame, 'the checksum does not fit');
}

/** Returns the manifold surface, whose further vertices are copies of the mesh's. */
function readSurface({ faces, copies }, positions, ownFaces) {
  const n = positions.length / 3;
  check(copies.every((vertex) => vertex < n), 'a copy of an unknown vertex');
  if (faces) {
    check(faces.length === ownFaces.length, 'a surface of other faces');
    checkFaces(faces, n + copies.length);
  }
  return { faces: faces ?? ownFaces, copies, isMesh: faces === null && copies.length === 0 };
}

function checkFaces(faces, n) {
  check(faces.length > 0, 'it has no faces');
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [faces[i], faces[i + 1], faces[i + 2]];
    check(a < n && b < n && c < n, 'a face with an unknown vertex');
    check(a !== b && b !== c && c !== a, 'a face with equal corners');
  }
}

async function readMerges(reader) {
  const n = count(reader, MERGE);
  const { view, at } = take(reader, MERGE * n);
  const merges = { n, kept: new Uint32Array(n), removed: new Uint32Array(n), positions: new Float32Array(3 * n) };
  await inSlices(n, (from, to) => {
    for (let i = from; i < to; i++) {
      const row = at + MERGE * i;
      merges.kept[i] = view.getUint32(row, true);
      merges.removed[i] = view.getUint32(row + 4, true);
      for (let axis = 0; axis < 3; axis++) merges.positions[3 * i + axis] = view.getFloat32(row + 8 + 4 * axis, true);
    }
  });
  check(merges.positions.every(Number.isFinite), 'a merge to a position that is not finite');
  return merges;
}

function readDrop(reader) {
  const drop = { nVertices: length(reader), components: wordRows(reader, 1) };
  skipRows(reader, DROPPED);
  return drop;
}

/** Skips wedges, channels, groups, kept faces and locked vertices; returns whether there are normals. */
function skipAttributes(reader) {
  skipRows(reader, 12);
  const roles = list(reader, 25, () => {
    skipRows(reader, 1);
    const role = byte(reader);
    length(reader);
    skipRows(reader, 4);
    return role;
  });
  for (const stride of [4, 1, 1]) skipRows(reader, stride);
  return roles.includes(0);
}

/** Skips the placement in a scene; returns the diagonal of the scene's box, or null without a scene. */
function skipScene(reader) {
  return optional(reader, () => {
    skipRows(reader, 4);
    list(reader, 8, () => list(reader, 8, () => skipRows(reader, 1)));
    skipRows(reader, 4);
    skipRows(reader, 1);
    list(reader, 8, () => skipRows(reader, 128));
    return float(reader);
  });
}

/** Skips options, scores, kept edges and the end of the collapse. */
function skipOptions(reader) {
  take(reader, 4 + 16 + 3 + 8 + 1);
  optional(reader, () => take(reader, 4));
  take(reader, 1 + 25 + 1 + 8 + 1);
}

function skipOrigin(reader) {
  length(reader);
  for (let i = 0; i < 2; i++) optional(reader, () => skipRows(reader, 4));
  take(reader, 16);
  skipRows(reader, DROPPED);
}

/** Moves past a number of bytes; returns where they begin. */
function take(reader, n) {
  check(n <= reader.end - reader.at, 'a list is longer than the file');
  const { at, view } = reader;
  reader.at += n;
  return { at, view };
}

function byte(reader) {
  return reader.bytes[take(reader, 1).at];
}

function float(reader) {
  return reader.view.getFloat64(take(reader, 8).at, true);
}

function length(reader) {
  const n = Number(reader.view.getBigUint64(take(reader, 8).at, true));
  check(Number.isSafeInteger(n), 'an impossible number');
  return n;
}

/** Returns the length of a list whose rows have at least so many bytes, which must fit into the file. */
function count(reader, least) {
  const n = length(reader);
  check(n <= (reader.end - reader.at) / least, 'a list is longer than the file');
  return n;
}

function skipRows(reader, stride) {
  take(reader, stride * count(reader, stride));
}

function list(reader, least, read) {
  return Array.from({ length: count(reader, least) }, read);
}

function optional(reader, read) {
  const flag = byte(reader);
  check(flag < 2, 'a choice that is none');
  return flag === 1 ? read() : null;
}

function floatRows(reader, width) {
  return new Float32Array(rows(reader, width));
}

function wordRows(reader, width) {
  return new Uint32Array(rows(reader, width));
}

/** Returns a copy of a list of rows of 4-byte numbers, which may begin between two numbers in the file. */
function rows(reader, width) {
  const n = 4 * width * count(reader, 4 * width);
  const { at } = take(reader, n);
  return reader.bytes.slice(at, at + n).buffer;
}

/** Throws an error that the file is damaged unless a condition holds. */
export function check(holds, what) {
  if (!holds) throw new Error(`damaged progression: ${what}`);
}

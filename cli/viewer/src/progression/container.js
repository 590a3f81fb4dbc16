// Reads `.nmp` files, which docs/progression.md describes. No byte is trusted.

import { inSlices } from '../slices.js';
import { checksumOf } from './checksum.js';

const VERSION = 2;
const MAGIC = 'NMESHPRG';
const HEAD = 12;
/** Bytes of a merge, and of a dropped component. */
const MERGE = 21;
const DROPPED = 12;
/** Stored numbers of roles of channels. */
export const ROLES = { normal: 0, uv: 2, colour: 3 };

/**
 * Reads a file, a blob: positions and faces of the mesh; `attributes` {wedges, channels, groups}; `surface`, faces and copied vertices, if
 * the merges are of a mesh that was split to become manifold; the merges; `size`, the numbers of vertices and faces that shares refer
 * to; dropped components; proved levels; `placement` in a scene, else null; `origin` of the coordinates; `hasNormals`; the file of the mesh as
 * `source`, if it is inside.
 */
export async function readProgression(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  await checkEnds(bytes);
  const reader = { bytes, view: new DataView(bytes.buffer), at: HEAD, end: bytes.length - 8 };
  const [positions, faces] = [floatRows(reader, 3), wordRows(reader, 3)];
  const attributes = readAttributes(reader);
  const placement = readPlacement(reader);
  const origin = readOrigin(reader);
  const size = [length(reader), length(reader)];
  for (let origin = 0; origin < 2; origin++) skipOrigin(reader);
  const surface = { faces: optional(reader, () => wordRows(reader, 3)), copies: wordRows(reader, 1) };
  const merges = await readMerges(reader);
  const drops = list(reader, 24, () => readDrop(reader));
  const proofs = list(reader, 16, () => ({ nVertices: length(reader), distance: float(reader) }));
  check(proofs.every(({ nVertices, distance }) => nVertices > 0 && distance >= 0), 'a proved level without a distance');
  const files = list(reader, 16, () => ({ name: new TextDecoder().decode(byteRow(reader)), bytes: byteRow(reader) }));
  check(positions.every(Number.isFinite), 'a position that is not finite');
  checkFaces(faces, positions.length / 3);
  checkAttributes(attributes, faces.length / 3);
  const hasNormals = attributes.channels.some(({ role }) => role === ROLES.normal);
  return {
    positions, faces, attributes, surface: readSurface(surface, positions, faces), merges, size, drops, proofs, placement, origin, hasNormals,
    source: files[0] ?? null,
  };
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

/** Reads the wedges of each face, channels {name, role, width, values}, and the group of each face; skips kept faces and locked vertices. */
function readAttributes(reader) {
  const wedges = wordRows(reader, 3);
  const channels = list(reader, 25, () => {
    const name = new TextDecoder().decode(byteRow(reader));
    const role = byte(reader);
    return { name, role, width: length(reader), values: floatRows(reader, 1) };
  });
  const groups = wordRows(reader, 1);
  for (let i = 0; i < 2; i++) skipRows(reader, 1);
  return { wedges, channels, groups };
}

function checkAttributes({ wedges, channels, groups }, nFaces) {
  check(groups.length === 0 || groups.length === nFaces, 'groups of other faces');
  if (channels.length === 0) return;
  check(wedges.length === 3 * nFaces, 'wedges of other faces');
  const nWedges = wedges.reduce((most, wedge) => Math.max(most, wedge + 1), 0);
  for (const { width, values } of channels) check(width > 0 && nWedges <= values.length / width, 'a wedge without values');
}

/** Reads the placement in a scene: the first group of each piece, matrices of its instances by columns, and the scene's diagonal. */
function readPlacement(reader) {
  return optional(reader, () => {
    const firstGroups = wordRows(reader, 1);
    list(reader, 8, () => list(reader, 8, () => skipRows(reader, 1)));
    skipRows(reader, 4);
    skipRows(reader, 1);
    const places = list(reader, 8, () => list(reader, 128, () => Array.from({ length: 16 }, () => float(reader))));
    check(places.flat(2).every(Number.isFinite) && firstGroups.length === places.length + 1, 'a placement that is none');
    return { firstGroups, places, diagonal: float(reader) };
  });
}

/** Skips options, scores, kept edges and the end of the collapse; returns the origin of the coordinates, which is among them. */
function readOrigin(reader) {
  take(reader, 4 + 16 + 3 + 8 + 1);
  optional(reader, () => take(reader, 4));
  take(reader, 1);
  const origin = [0, 1, 2].map(() => float(reader));
  take(reader, 1 + 1 + 8 + 1);
  return origin;
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

function byteRow(reader) {
  const n = count(reader, 1);
  const { at } = take(reader, n);
  return reader.bytes.subarray(at, at + n);
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

// What was dropped or chosen: its files, and which of them are meshes.

import { isCompanion, readBelongings } from './belongings.js';

/** Endings of meshes, those first whose files name others. */
const ENDINGS = ['gltf', 'glb', 'obj', '3mf', 'ply', 'stl', 'off'];

/** The ending of a mesh's name without `.gz`, in small letters; empty where it has none. */
export function endingOf(name) {
  return name.toLowerCase().replace(/\.gz$/, '').match(/\.([^./]+)$/)?.[1] ?? '';
}

/** The name without folders and endings. */
export function stemOf(name) {
  return name.split('/').pop().replace(/\.gz$/i, '').replace(/\.[^.]+$/, '') || 'mesh';
}

/** The files of a drop, also those in folders, as {path, file}. */
export async function filesOfDrop({ items, files }) {
  // Entries are gone after the first wait.
  const entries = [...items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (entries.length === 0) return [...files].map((file) => ({ path: file.name, file }));
  return (await Promise.all(entries.map(filesOfEntry))).flat();
}

async function filesOfEntry(entry) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [{ path: entry.fullPath.replace(/^\//, ''), file }];
  }
  const reader = entry.createReader();
  const inside = [];
  // A reader gives some at a time, and none when it is through.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) break;
    inside.push(...some);
  }
  return (await Promise.all(inside.map(filesOfEntry))).flat();
}

/** The files of an input element, as {path, file}. */
export function filesOfInput({ files }) {
  return [...files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}

/** The meshes among files, the one to open first. */
export function meshesAmong(files) {
  const rank = ({ path }) => ENDINGS.indexOf(endingOf(path));
  const meshes = files.filter((one) => rank(one) >= 0);
  // A file of an unknown ending may still be a mesh; the simplifier says what is wrong with it.
  const unknown = files.filter(({ path }) => !isCompanion(path));
  if (meshes.length === 0) return unknown.length === 1 ? unknown : [];
  return meshes.sort((a, b) => rank(a) - rank(b) || a.path.localeCompare(b.path, 'en', { numeric: true }));
}

/** Reads a mesh with what belongs to it. */
export async function readMesh(mesh, files) {
  const beside = await readBelongings(mesh, endingOf(mesh.path), files);
  return { name: mesh.path.split('/').pop(), bytes: new Uint8Array(await mesh.file.arrayBuffer()), beside };
}

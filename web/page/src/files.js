// Reads dropped and chosen files, and finds the meshes among them.

import { isCompanion, readCompanions } from './companions.js';

/** Extensions of meshes; formats that refer to other files come first. */
const ENDINGS = ['gltf', 'glb', 'obj', '3mf', 'ply', 'stl', 'off'];

/** Returns the extension of a mesh's name without `.gz`, in lower case; empty if there is none. */
export function endingOf(name) {
  return name.toLowerCase().replace(/\.gz$/, '').match(/\.([^./]+)$/)?.[1] ?? '';
}

/** Returns the name without folders and extensions. */
export function stemOf(name) {
  return name.split('/').pop().replace(/\.gz$/i, '').replace(/\.[^.]+$/, '') || 'mesh';
}

/** Lists the files of a drop, including those in folders, as {path, file}. */
export async function filesOfDrop({ items, files }) {
  // The browser clears the entries after the first await.
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
  // A reader returns some entries at a time, and none at the end.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) break;
    inside.push(...some);
  }
  return (await Promise.all(inside.map(filesOfEntry))).flat();
}

/** Lists the files of an input element, as {path, file}. */
export function filesOfInput({ files }) {
  return [...files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}

/** Lists the meshes among files, starting with the one to open. */
export function meshesAmong(files) {
  const rank = ({ path }) => ENDINGS.indexOf(endingOf(path));
  const meshes = files.filter((one) => rank(one) >= 0);
  // A file with an unknown extension may still be a mesh; if not, the package reports the error.
  const unknown = files.filter(({ path }) => !isCompanion(path));
  if (meshes.length === 0) return unknown.length === 1 ? unknown : [];
  return meshes.sort((a, b) => rank(a) - rank(b) || a.path.localeCompare(b.path, 'en', { numeric: true }));
}

/** Reads a mesh with the files that belong to it. */
export async function readMesh(mesh, files) {
  const beside = await readCompanions(mesh, endingOf(mesh.path), files);
  return { name: mesh.path.split('/').pop(), bytes: new Uint8Array(await mesh.file.arrayBuffer()), beside };
}

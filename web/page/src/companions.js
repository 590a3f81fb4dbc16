// Finds the files that belong to a mesh: those that it refers to, under the paths that it uses.

/** Bytes at the front of a file that are searched for references to other files. */
const FRONT = 1 << 20;

const TEXTURE = /\.(bin|png|jpe?g|webp|ktx2)$/i;

/** Returns whether a file is not a mesh but can belong to one. */
export function isCompanion(path) {
  return TEXTURE.test(path) || /\.mtl$/i.test(path);
}

/**
 * Reads what belongs to a mesh {path, file} among files: bytes by path. A glTF names buffers and images, a PLY images in its header, an
 * OBJ materials, and these images.
 */
export async function readCompanions(mesh, ending, files) {
  const others = files.filter((one) => one !== mesh);
  const textures = others.filter(({ path }) => TEXTURE.test(path));
  const folder = folderOf(mesh.path);
  if (ending === 'gltf') return bytesOf(named(await mesh.file.text(), textures, folder));
  const front = await mesh.file.slice(0, FRONT).text();
  if (ending === 'ply') return bytesOf(named(front.slice(0, front.indexOf('end_header')), textures, folder));
  if (ending !== 'obj') return {};
  const materials = named(front, others.filter(({ path }) => /\.mtl$/i.test(path)), folder);
  const texts = await Promise.all(materials.map(({ file }) => file.text()));
  return bytesOf([...materials, ...named(texts.join('\n'), textures, folder)]);
}

/** Returns the files that a text refers to, under the paths of the references if the folders differ. */
function named(text, files, folder) {
  return files.flatMap(({ path, file }) => {
    const name = path.split('/').pop();
    const spelled = [name, encodeURI(name), encodeURIComponent(name)].find((way) => text.includes(way));
    if (!spelled) return [];
    const reference = text.match(new RegExp(`[^\\s"]*${spelled.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')}`))[0];
    const seen = relative(folder, path);
    // Files that were dropped without their folders are found by name.
    const isThere = seen.endsWith(plain(reference));
    return [{ path: isThere ? seen : plain(reference), file }];
  });
}

/** Converts a reference to a path: decodes `%20`, replaces `\` by `/`, and removes `./`. */
function plain(reference) {
  let path = reference;
  try {
    path = decodeURI(reference);
  } catch {
    // The percent sign is no escape.
  }
  return path.replaceAll('\\', '/').replace(/^(\.\/)+/, '');
}

async function bytesOf(files) {
  const read = async ({ path, file }) => [path, new Uint8Array(await file.arrayBuffer())];
  return Object.fromEntries(await Promise.all(files.map(read)));
}

function folderOf(path) {
  return path.split('/').slice(0, -1);
}

/** Returns a path relative to a folder. */
function relative(folder, path) {
  const parts = path.split('/');
  let same = 0;
  while (same < folder.length && same < parts.length - 1 && folder[same] === parts[same]) same++;
  return [...folder.slice(same).map(() => '..'), ...parts.slice(same)].join('/');
}

// Materials and textures of the GLB from which a progression was made, for levels that are saved as GLB.

const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
/** Modes of primitives that have triangles; the file's default is 4. */
const TRIANGLES = [4, 5, 6];

/**
 * Returns the JSON of a GLB, its bytes behind it, and the material of each group of faces; null if the file is no GLB, or if its
 * primitives are not the groups of the scene.
 */
export function readMaterials(source, placement) {
  const chunks = source && placement ? readChunks(source.bytes) : null;
  if (!chunks?.json.materials) return null;
  const meshes = (chunks.json.meshes ?? []).map(({ primitives }) => primitives.filter(({ mode }) => TRIANGLES.includes(mode ?? 4)));
  const pieces = meshes.filter((primitives) => primitives.length > 0);
  let group = 0;
  const firsts = [0, ...pieces.map((primitives) => { group += primitives.length; return group; })];
  // A mesh that cleaning has emptied is no piece; then groups have other numbers.
  const isSame = firsts.length === placement.firstGroups.length && firsts.every((first, i) => first === placement.firstGroups[i]);
  return isSame ? { ...chunks, ofGroups: pieces.flat().map(({ material }) => material ?? null) } : null;
}

/** Returns the JSON and the binary chunk of a GLB, or null. */
function readChunks(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  if (bytes.length < 20 || view.getUint32(0, true) !== MAGIC || view.getUint32(16, true) !== JSON_CHUNK) return null;
  const end = 20 + view.getUint32(12, true);
  try {
    return { json: JSON.parse(new TextDecoder().decode(bytes.subarray(20, end))), binary: bytes.subarray(end + 8) };
  } catch {
    return null;
  }
}

/**
 * Returns materials, textures, samplers and images of a GLB for another one with the first texture coordinates alone, or none.
 * `addBytes(bytes)` stores an image and returns its view.
 */
export function copyMaterials({ json, binary }, hasUv, addBytes) {
  // Images in files of their own are not there.
  const isWhole = (json.images ?? []).every(({ bufferView, uri }) => bufferView !== undefined || uri?.startsWith('data:'));
  const hasTextures = hasUv && isWhole;
  const copyImage = ({ bufferView, ...image }) => (
    bufferView === undefined ? image : { ...image, bufferView: addBytes(bytesOfView(json, binary, bufferView)) }
  );
  const images = hasTextures ? (json.images ?? []).map(copyImage) : [];
  const textures = hasTextures ? json.textures : [];
  const materials = json.materials.map((material) => withoutTextures(material, (texture) => hasTextures && !texture.texCoord));
  const used = JSON.stringify([materials, textures ?? []]);
  const extensions = (json.extensionsUsed ?? []).filter((name) => used.includes(`"${name}"`));
  const required = (json.extensionsRequired ?? []).filter((name) => extensions.includes(name));
  const lists = { materials, textures, samplers: hasTextures ? json.samplers : [], images, extensionsUsed: extensions, extensionsRequired: required };
  // Empty lists are not allowed.
  return Object.fromEntries(Object.entries(lists).filter(([, list]) => list?.length > 0));
}

function bytesOfView({ bufferViews }, binary, index) {
  const { byteOffset = 0, byteLength } = bufferViews[index];
  return binary.subarray(byteOffset, byteOffset + byteLength);
}

/** Returns a material, or a part of one, without the textures that `keeps` refuses. */
function withoutTextures(part, keeps) {
  const entries = Object.entries(part).filter(([key, value]) => !/Texture$/.test(key) || keeps(value));
  const isPart = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
  return Object.fromEntries(entries.map(([key, value]) => [key, isPart(value) ? withoutTextures(value, keeps) : value]));
}

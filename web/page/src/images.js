// Stores the images of all open meshes, each once, as results share textures with their original.

/** Creates an empty store. */
export function makeImages() {
  return { blobs: [], known: new Map() };
}

/** Returns the number of an image, adding it if new; null without an image. */
export function numberOfImage(images, bytes) {
  if (!bytes || bytes.length === 0) return null;
  const key = `${bytes.length} ${digest(bytes)}`;
  if (!images.known.has(key)) {
    images.known.set(key, images.blobs.length);
    images.blobs.push(new Blob([bytes], { type: typeOf(bytes) }));
  }
  return images.known.get(key);
}

/** Returns a hash of two 32-bit numbers. */
function digest(bytes) {
  let [a, b] = [0x811c9dc5, 0x9e3779b1];
  for (const byte of bytes) {
    a = Math.imul(a ^ byte, 0x01000193);
    b = Math.imul(b, 31) + byte | 0;
  }
  return `${a >>> 0} ${b >>> 0}`;
}

function typeOf(bytes) {
  if (bytes[0] === 0x89) return 'image/png';
  return bytes[0] === 0xff ? 'image/jpeg' : 'image/webp';
}

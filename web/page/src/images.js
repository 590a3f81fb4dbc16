// The images of all meshes that are open, each once: a result carries the same textures as its original.

/** Makes an empty collection. */
export function makeImages() {
  return { blobs: [], known: new Map() };
}

/** The number of an image; null where there is none. */
export function numberOfImage(images, bytes) {
  if (!bytes || bytes.length === 0) return null;
  const key = `${bytes.length} ${digest(bytes)}`;
  if (!images.known.has(key)) {
    images.known.set(key, images.blobs.length);
    images.blobs.push(new Blob([bytes], { type: typeOf(bytes) }));
  }
  return images.known.get(key);
}

/** Two numbers of 32 bits that hardly any other bytes have. */
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

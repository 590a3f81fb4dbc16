// Compiles the WebAssembly that the build packs into modules as gzipped base64 text.

import { importNode } from './thread.js';

/** Decodes, decompresses and compiles a packed WebAssembly module. */
export async function compilePacked(text) {
  return WebAssembly.compile(await unzip(decodeBase64(text)));
}

function decodeBase64(text) {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

async function unzip(bytes) {
  if (typeof DecompressionStream === 'undefined') return (await importNode('node:zlib')).gunzipSync(bytes);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

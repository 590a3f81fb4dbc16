// Compiles the WebAssembly that the build packs into modules as gzipped base64 text.

import { importNode, inNode } from './thread.js';

/** Decodes, decompresses and compiles a packed WebAssembly module. */
export async function compilePacked(text) {
  return WebAssembly.compile(await unzip(decodeBase64(text)));
}

function decodeBase64(text) {
  // Engines decode much faster than the loop; Node has loaded its own decoder anyhow.
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  if (globalThis.Buffer?.from) return globalThis.Buffer.from(text, 'base64');
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

async function unzip(bytes) {
  // Node loads the classes of streams at their first use, which takes longer than all else here.
  if (inNode() || typeof DecompressionStream === 'undefined') return (await importNode('node:zlib')).gunzipSync(bytes);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

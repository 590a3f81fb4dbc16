// From the text in a module of this package to a compiled WebAssembly module: base64, gzip, compilation.

import { importNode } from './thread.js';

/** Compiles what the build packed. */
export async function compilePacked(text) {
  return WebAssembly.compile(await unzip(decodeBase64(text)));
}

function decodeBase64(text) {
  const characters = atob(text);
  return Uint8Array.from({ length: characters.length }, (_, i) => characters.charCodeAt(i));
}

async function unzip(bytes) {
  if (typeof DecompressionStream === 'undefined') return (await importNode('node:zlib')).gunzipSync(bytes);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

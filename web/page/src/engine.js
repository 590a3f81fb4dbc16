// Calls the package for the page: files in, files and numbers out, each call in a worker.
//
// A file is {name, bytes, beside}, where `beside` has the bytes of the files that belong to it by path.

import { compare, formats, look, simplify } from 'neural-mesh';

/** Lists the extensions of the formats that are written. */
export async function listFormats() {
  const { write } = await formats();
  // Text formats such as `ply-ascii` share the extension of the binary one.
  return write.filter((name) => !name.includes('-'));
}

/** Simplifies a small file in a worker of its own: browsers compile the functions that run often faster while nobody waits for them. */
export async function warmUpEngine({ name, bytes }) {
  const { files: [made] } = await simplify(bytes, { ratio: 0.1, no_check: true }, { name, out: 'small.glb' });
  await look(made.bytes, { name: made.name });
}

/** Reads a file as a mesh to draw, with notes for the reader. */
export function lookAtFile({ name, bytes, beside }, { signal }) {
  return look(bytes, { name, beside, signal });
}

/** Simplifies a file and returns the result's file, the report, and notes for the reader. */
export async function simplifyFile({ name, bytes, beside }, options, out, { signal, progress }) {
  const overall = (share, part) => progress(shareOfWork(share, part));
  const { files, report, notes } = await simplify(bytes, options, { name, beside, out, signal, progress: overall });
  const others = files.flatMap((file, i) => (i === 0 ? file.beside : [file, ...file.beside]));
  const besides = Object.fromEntries(others.map((file) => [file.name, file.bytes]));
  return { file: { name: files[0].name, bytes: files[0].bytes, beside: besides }, report, notes };
}

/** Measures a result against its original: figures, both surfaces, and distances at points of these. */
export async function compareFiles(original, result, { signal, progress }) {
  const { comparison, surfaces, distances: [both] } = await compare(original, result, { signal, progress });
  return { comparison, surfaces, distances: { ofOriginal: both.of_original, ofResult: both.of_result } };
}

/** Returns the share of a run that is done, from the share of its current stage: reading, simplifying, or later ones. */
function shareOfWork(share, part) {
  if (part === 0) return 0.1 * share;
  return part === 1 ? 0.1 + 0.85 * share : 0.95;
}

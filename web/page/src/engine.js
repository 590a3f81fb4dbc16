// The simplifier as the page uses it: files in, files and numbers out, each call in a worker of the package.
//
// A file is {name, bytes, beside}, `beside` the bytes of files that belong to it by their paths.

import { compare, formats, look, simplify } from 'neural-mesh';

/** The formats that are written, by the endings of their names. */
export async function listFormats() {
  const { write } = await formats();
  // A format in words, as `ply-ascii`, has the ending of the other.
  return write.filter((name) => !name.includes('-'));
}

/** The mesh of a file as it is drawn, and what is to be said about it. */
export function lookAtFile({ name, bytes, beside }, { signal }) {
  return look(bytes, { name, beside, signal });
}

/** Makes a file lighter: the file of the result, the program's report, and what is to be said about it. */
export async function simplifyFile({ name, bytes, beside }, options, out, { signal, progress }) {
  const overall = (share, part) => progress(shareOfWork(share, part));
  const { files, report, notes } = await simplify(bytes, options, { name, beside, out, signal, progress: overall });
  const others = files.flatMap((file, i) => (i === 0 ? file.beside : [file, ...file.beside]));
  const besides = Object.fromEntries(others.map((file) => [file.name, file.bytes]));
  return { file: { name: files[0].name, bytes: files[0].bytes, beside: besides }, report, notes };
}

/** Measures a result against its original: the figures, the surfaces of both, and distances at points of these. */
export async function compareFiles(original, result, { signal, progress }) {
  const { comparison, surfaces, distances: [both] } = await compare(original, result, { signal, progress });
  return { comparison, surfaces, distances: { ofOriginal: both.of_original, ofResult: both.of_result } };
}

/** How much of a run is done, by the share of one of its parts: reading, simplifying, and what follows these. */
function shareOfWork(share, part) {
  if (part === 0) return 0.1 * share;
  return part === 1 ? 0.1 + 0.85 * share : 0.95;
}

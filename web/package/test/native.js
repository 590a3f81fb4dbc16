// Compares the package with the native program of the same sources, on one thread: `node test/native.js PROGRAM MESH...`
//
// Prints a row for each mesh and ratio, native / package: faces, what is equal of the files, mean and largest distance to the original in
// percent of its diagonal, edges without two faces, and the best time of three. The package's first call is timed alone.
//
// Equal are all bytes; or the faces, with numbers that differ by a share of the extent; or nothing: the last bits of numbers decide which of two
// edges that cost the same goes, and they may differ between processors.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';

import { built } from './built.js';

const RATIOS = [0.5, 0.1];
const RUNS = 3;
const [program, ...meshes] = process.argv.slice(2);
if (meshes.length === 0) {
  console.error('node test/native.js PROGRAM MESH...');
  process.exit(2);
}
const { compare, look, simplify } = await built('index');
const folder = mkdtempSync(join(tmpdir(), 'native-'));

/** Runs `work` several times. Returns its last result and the least milliseconds. */
async function timed(work, runs = RUNS) {
  let [result, least] = [null, Infinity];
  for (let i = 0; i < runs; i++) {
    const from = performance.now();
    result = await work();
    least = Math.min(least, performance.now() - from);
  }
  return { result, ms: least };
}

/** Simplifies with the native program; the time is that of the process with files read and written. */
async function runNative(mesh, ratio) {
  const [out, report] = [join(folder, 'light.ply'), join(folder, 'report.json')];
  const words = ['simplify', mesh, '--ratio', ratio, '--threads', 1, '--no-check', '--report', report, '--output', out, '--force'];
  const { ms } = await timed(() => execFileSync(program, words.map(String), { stdio: 'pipe' }));
  return { name: 'native.ply', bytes: new Uint8Array(readFileSync(out)), report: JSON.parse(readFileSync(report, 'utf8')), ms };
}

/** Simplifies with the package; the time is that of the call with bytes sent to and from the worker. */
async function runPackage(name, bytes, ratio) {
  const { result, ms } = await timed(() => simplify(bytes, { ratio, no_check: true }, { name, out: 'light.ply' }));
  return { name: 'package.ply', bytes: result.bytes, report: result.report, ms };
}

/** Describes how equal two files are: bytes, faces, or nothing. */
async function equality(files) {
  if (Buffer.compare(files[0].bytes, files[1].bytes) === 0) return 'bytes';
  const [one, other] = await Promise.all(files.map(async ({ name, bytes }) => (await look(bytes, { name })).mesh));
  if (one.faces.length !== other.faces.length || one.faces.some((vertex, i) => vertex !== other.faces[i])) return 'no';
  const at = ({ positions, origin }, i) => positions[i] + origin[i % 3];
  let [difference, extent] = [0, 0];
  for (let i = 0; i < one.positions.length; i++) {
    difference = Math.max(difference, Math.abs(at(one, i) - at(other, i)));
    extent = Math.max(extent, Math.abs(at(one, i) - at(one, i % 3)));
  }
  return `faces, ${(difference / extent).toExponential(0)}`;
}

const both = (values, digits) => values.map((value) => value.toFixed(digits)).join(' / ');
const columns = ['mesh', 'ratio', 'faces', 'equal', 'mean %', 'largest %', 'bad edges %', 'ms'];
const widths = [18, 6, 16, 14, 18, 18, 14, 16];
const printRow = (cells) => console.log(cells.map((cell, i) => `${cell}`.padEnd(widths[i])).join(' ').trimEnd());

async function printComparison(mesh, bytes, ratio) {
  const name = basename(mesh);
  const runs = [await runNative(mesh, ratio), await runPackage(name, bytes, ratio)];
  const { comparison } = await compare({ name, bytes }, runs.map((run) => ({ name: run.name, bytes: run.bytes })));
  const figure = (key) => comparison.results.map(({ values }) => values[key]);
  printRow([
    name, ratio, both(runs.map(({ report }) => report.output.faces), 0),
    await equality(runs), both(figure('distance_mean'), 4), both(figure('distance_max'), 3), both(figure('edges_without_two_faces'), 2),
    both(runs.map(({ ms }) => ms), 0),
  ]);
}

try {
  const first = await timed(() => simplify(readFileSync(meshes[0]), { ratio: RATIOS[0], no_check: true }, { name: basename(meshes[0]) }), 1);
  console.log(`native / package; the package's first call: ${first.ms.toFixed(0)} ms`);
  printRow(columns);
  for (const mesh of meshes) {
    const bytes = new Uint8Array(readFileSync(mesh));
    for (const ratio of RATIOS) await printComparison(mesh, bytes, ratio);
  }
} finally {
  rmSync(folder, { recursive: true });
}

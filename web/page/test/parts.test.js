// Tests the modules of the page that need no browser: jobs, files, edges, archives, recipes.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { test } from 'node:test';
import { readCompanions } from '../src/companions.js';
import { findEdges } from '../src/edges.js';
import { EXAMPLES } from '../src/examples.js';
import { endingOf, meshesAmong, stemOf } from '../src/files.js';
import { ask, cancel, makeJobs } from '../src/jobs.js';
import { recipesOf } from '../src/recipes.js';
import { scaleOf } from '../src/scale.js';
import { LEVELS, placeOfShare, shareAt } from '../src/sizes.js';
import { weldVertices } from '../src/weld.js';
import { zip } from '../src/zip.js';

/** Creates a job that ends on request or when aborted. */
function pausing(log, key, urgency) {
  const run = ({ signal }) => new Promise((resolve, reject) => {
    log.push(key);
    signal.addEventListener('abort', () => reject(signal.reason));
    setTimeout(() => resolve(key), 20);
  });
  return { owner: null, key, title: key, urgency, run };
}

test('the most urgent job comes first, and what it interrupts comes again', async () => {
  const [jobs, log] = [makeJobs(() => {}), []];
  const slow = ask(jobs, pausing(log, 'level', 2));
  const figures = ask(jobs, pausing(log, 'figures', 3));
  const wanted = ask(jobs, pausing(log, 'wanted', 0));
  assert.deepEqual(await Promise.all([wanted, slow, figures]), ['wanted', 'level', 'figures']);
  assert.deepEqual(log, ['level', 'wanted', 'level', 'figures']);
});

test('a job that is asked for twice runs once, as soon as the more urgent wants it', async () => {
  const [jobs, log] = [makeJobs(() => {}), []];
  const first = ask(jobs, pausing(log, 'a', 0));
  const others = [ask(jobs, pausing(log, 'b', 2)), ask(jobs, pausing(log, 'c', 2)), ask(jobs, pausing(log, 'c', 1))];
  await Promise.all([first, ...others]);
  assert.deepEqual(log, ['a', 'c', 'b']);
});

test('jobs of different owners are different, and a job that was given up is no answer', async () => {
  const [jobs, log] = [makeJobs(() => {}), []];
  const first = ask(jobs, pausing(log, 'a', 2));
  const second = ask(jobs, { ...pausing(log, 'a', 2), owner: jobs });
  cancel(jobs, ({ owner }) => owner === null);
  const third = ask(jobs, pausing(log, 'a', 2));
  await assert.rejects(first, { name: 'AbortError' });
  assert.deepEqual(await Promise.all([second, third]), ['a', 'a']);
  assert.equal(log.length, 3);
});

test('cancelled jobs are given up, and others can follow', async () => {
  const [jobs, log] = [makeJobs(() => {}), []];
  const given = [ask(jobs, pausing(log, 'a', 2)), ask(jobs, pausing(log, 'b', 2))];
  cancel(jobs);
  for (const one of given) await assert.rejects(one, { name: 'AbortError' });
  assert.equal(await ask(jobs, pausing(log, 'c', 2)), 'c');
});

test('the mesh among files is the one that names others', () => {
  const files = ['a/skin.png', 'a/cow.bin', 'a/part.ply', 'a/cow.gltf', 'a/notes.txt'].map((path) => ({ path }));
  assert.deepEqual(meshesAmong(files).map(({ path }) => path), ['a/cow.gltf', 'a/part.ply']);
  assert.deepEqual(meshesAmong([{ path: 'skin.png' }]), []);
  assert.deepEqual([endingOf('A/Cow.OBJ.gz'), endingOf('cow'), stemOf('a/cow.v2.obj.gz')], ['obj', '', 'cow.v2']);
});

test('files belong to a mesh by the paths that it names, with folders or without', async () => {
  const file = (path, text) => ({ path, file: new Blob([text]) });
  const obj = file('cow/cow.obj', 'mtllib cow.mtl\n');
  const inFolder = [obj, file('cow/cow.mtl', 'map_Kd -bm 1 maps/my%20skin.png\n'), file('cow/maps/my skin.png', 'x'), file('cow/other.png', 'y')];
  assert.deepEqual(Object.keys(await readCompanions(obj, 'obj', inFolder)), ['cow.mtl', 'maps/my skin.png']);
  const gltf = file('a.gltf', '{"images":[{"uri":"./textures/skin.png"}],"buffers":[{"uri":"a.bin"}]}');
  const loose = [gltf, file('skin.png', 'x'), file('a.bin', 'y'), file('b.bin', 'z')];
  assert.deepEqual(Object.keys(await readCompanions(gltf, 'gltf', loose)), ['textures/skin.png', 'a.bin']);
  const ply = file('a.ply', 'ply\ncomment TextureFile skin.png\nend_header\nb.png');
  assert.deepEqual(Object.keys(await readCompanions(ply, 'ply', [ply, file('skin.png', 'x'), file('b.png', 'y')])), ['skin.png']);
});

test('split vertices are welded, and edges are found with their kinds', async () => {
  // Two faces share an edge with duplicate vertices, and the second face is turned.
  const positions = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, -0, 1, 0, 1, 1, 0);
  const { pointOf, firstOf } = await weldVertices(positions);
  assert.deepEqual([...pointOf], [0, 1, 2, 1, 2, 3]);
  assert.deepEqual([...firstOf], [0, 1, 2, 5]);
  const { all, marked } = findEdges(Uint32Array.of(0, 1, 2, 1, 2, 3), 4);
  assert.equal(all.length, 10);
  assert.deepEqual(marked.map((edges) => edges.length / 2), [4, 0, 1]);
});

for (const [name, genus] of [['Knot', 1], ['Gear', 1], ['Planet', 0]]) {
  test(`the example ${name} is closed, and its faces look outwards`, () => {
    const { bytes } = EXAMPLES[name]();
    const text = new TextDecoder('latin1').decode(bytes);
    const size = text.includes('uchar red') ? 15 : 12;
    const [nVertices, nFaces] = ['vertex', 'face'].map((part) => Number(text.match(new RegExp(`element ${part} (\\d+)`))[1]));
    const view = new DataView(bytes.buffer, text.indexOf('end_header\n') + 11 + size * nVertices);
    const faces = Uint32Array.from({ length: 3 * nFaces }, (_, i) => view.getInt32(13 * Math.floor(i / 3) + 1 + 4 * (i % 3), true));
    const { all, marked } = findEdges(faces, nVertices);
    assert.deepEqual(marked.map((edges) => edges.length), [0, 0, 0]);
    assert.equal(nVertices - all.length / 2 + nFaces, 2 - 2 * genus);
    const vertices = new DataView(bytes.buffer, text.indexOf('end_header\n') + 11);
    const point = (vertex) => [0, 1, 2].map((axis) => vertices.getFloat32(size * vertex + 4 * axis, true));
    let volume = 0;
    for (let i = 0; i < faces.length; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => point(faces[i + k]));
      volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    assert.ok(volume > 0);
  });
}

test('the colours end where so much of the area lies below', () => {
  const mesh = { positions: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 9, 0), faces: Uint32Array.of(0, 1, 2, 3, 4, 5) };
  const { p95, max } = scaleOf([{ values: Float32Array.of(4, 4, 4, 1, 1, 1), mesh }]);
  assert.equal(max, 4);
  assert.equal(p95, 4);
  assert.ok(Math.abs(scaleOf([{ values: Float32Array.of(1, 1, 1, 4, 4, 4), mesh }]).p95 - 4) < 1e-3);
  assert.ok(scaleOf([{ values: new Float32Array(6), mesh }]).max === 0);
});

test('every level has its place on the slider', () => {
  for (const share of [...LEVELS, 1]) assert.equal(shareAt(Math.round(placeOfShare(share) / 0.005) * 0.005), share);
});

test('recipes quote what shells and programs would misread', () => {
  const file = { name: "it's a cow.obj", beside: { 'maps/skin.png': 0 } };
  const [shell, python, script] = recipesOf(file, { size: { ratio: 0.1 }, options: { optimize: 'mean', subset: true } }, 'cow-10.obj');
  assert.equal(shell.text, "neural-mesh simplify 'it'\\''s a cow.obj' -o cow-10.obj --ratio 10% --optimize mean --subset");
  assert.ok(python.text.includes('nm.simplify("it\'s a cow.obj", ratio=0.1, optimize="mean", subset=True, out="cow-10.obj")'));
  assert.ok(script.text.includes("readFile('maps/skin.png')") && script.text.includes("{ ratio: 0.1, optimize: 'mean', subset: true }"));
});

test('an archive is read by others', async (t) => {
  const folder = mkdtempSync(`${tmpdir()}/zip-`);
  t.after(() => rmSync(folder, { recursive: true }));
  const bytes = Uint8Array.from({ length: 70_000 }, (_, i) => i * i);
  const archive = zip([{ name: 'a.gltf', bytes: new TextEncoder().encode('{}') }, { name: 'maps/ä.bin', bytes }]);
  writeFileSync(`${folder}/a.zip`, new Uint8Array(await archive.arrayBuffer()));
  execFileSync('python3', ['-m', 'zipfile', '-e', `${folder}/a.zip`, folder]);
  assert.deepEqual(new Uint8Array(readFileSync(`${folder}/maps/ä.bin`)), bytes);
});

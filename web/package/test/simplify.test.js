// Tests the whole program on files and arrays: formats, sizes, closed results, errors, comparison, surfaces to draw.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { gunzipSync, gzipSync } from 'node:zlib';

import { built } from './built.js';
import { openEdges, toObj, torus, unrolledTorus, utf8 } from './shapes.js';

const { compare, formats, look, simplify } = await built('index');
const spot = new Uint8Array(readFileSync(new URL('../../../tests/meshes/spot.ply', import.meta.url)));
const oneLine = { name: 'NeuralMeshError', message: /^[^\n]+$/ };
const { positions, faces } = torus();

/** A PNG of one red pixel. */
const PIXEL = Uint8Array.from(Buffer.from(
  'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC', 'base64',
));

test('arrays come back lighter and closed', async () => {
  const { results, files, bytes, report } = await simplify({ positions, faces }, { faces: 500 });
  assert.equal(results.length, 1);
  assert.deepEqual([files, bytes], [[], undefined]);
  assert.ok(results[0].positions instanceof Float32Array && results[0].faces instanceof Uint32Array);
  assert.ok(results[0].faces.length <= 1500 && results[0].faces.length >= 1450, `${results[0].faces.length}`);
  assert.equal(openEdges(results[0].positions, results[0].faces), 0);
  assert.equal(typeof report, 'object');
});

test('doubles come back as doubles', async () => {
  const far = Float64Array.from(positions, (x) => x + 1e7);
  const { results: [light] } = await simplify({ positions: far, faces }, { ratio: 0.3 });
  assert.ok(light.positions instanceof Float64Array);
  assert.equal(openEdges(light.positions, light.faces), 0);
  assert.ok(light.positions.every((x) => Math.abs(x - 1e7) < 4));
});

test('layers of arrays come back', async () => {
  const mesh = unrolledTorus();
  const nFaces = mesh.faces.length / 3;
  const input = {
    ...mesh,
    colors: Float32Array.from({ length: (4 * mesh.positions.length) / 3 }, (_, i) => (i % 4 === 3 ? 1 : 0.25)),
    groups: Uint32Array.from({ length: nFaces }, (_, i) => (i < nFaces / 2 ? 3 : 8)),
  };
  const { results: [light] } = await simplify(input, { ratio: 0.2, map: true });
  const n = light.positions.length / 3;
  assert.ok(light.faces.length < 0.4 * mesh.faces.length);
  assert.deepEqual([light.uv.length, light.normals.length, light.colors.length], [2 * n, 3 * n, 4 * n]);
  assert.deepEqual([...new Set(light.groups)].sort(), [3, 8]);
  assert.equal(light.groups.length, light.faces.length / 3);
  assert.equal(light.map.length, n);
  assert.ok(light.map.every((vertex) => vertex < mesh.positions.length / 3));
  assert.ok(light.uv.every((x) => x > -0.01 && x < 1.01));
  assert.equal(openEdges(light.positions, light.faces), 0);
});

test('plain lists of numbers are arrays, too', async () => {
  const typed = await simplify({ positions, faces }, { faces: 500 });
  const plain = await simplify({ positions: [...positions], faces: [...faces] }, { faces: 500 });
  assert.deepEqual(plain.results, typed.results);
});

test('arrays of the wrong length are refused', async () => {
  await assert.rejects(simplify({ positions: positions.subarray(1), faces }, { ratio: 0.5 }), { name: 'RangeError', message: /^positions: / });
  await assert.rejects(simplify({ positions, faces, uv: new Float32Array(3) }, { ratio: 0.5 }), { name: 'RangeError', message: /^uv: / });
  await assert.rejects(simplify({ positions, faces: 'abc' }, { ratio: 0.5 }), { name: 'TypeError', message: /^faces: / });
  await assert.rejects(simplify({ positions, faces: Uint32Array.of(0, 1, 1e6) }, { ratio: 0.5 }), oneLine);
});

test('a file keeps its format, and is read from bytes, buffers, blobs and files', async () => {
  const first = await simplify(spot, { ratio: 0.1 }, { name: 'spot.ply' });
  assert.equal(new TextDecoder().decode(first.bytes.subarray(0, 3)), 'ply');
  assert.equal(first.files[0].name, 'spot.ply');
  const inputs = [
    spot.slice().buffer, new Blob([spot]), new File([spot], 'spot.ply'),
    { name: 'spot.ply', bytes: spot }, { name: 'spot.ply', bytes: new Blob([spot]) },
  ];
  for (const input of inputs) {
    const { bytes } = await simplify(input, { ratio: 0.1 }, { out: 'x.ply' });
    assert.deepEqual(bytes, first.bytes);
  }
});

test('every format that is written is read', async () => {
  const { read, write, version } = await formats();
  assert.match(version, /^\d+\.\d+\.\d+/);
  for (const format of ['obj', 'ply', 'stl', 'off', 'gltf', 'glb']) assert.ok(read.includes(format) && write.includes(format), format);
  for (const format of write) {
    const { files: [file] } = await simplify({ positions, faces }, { faces: 500, format }, { arrays: false });
    const { results: [again] } = await simplify(file, { ratio: 1 }, { arrays: true });
    assert.ok(again.faces.length > 1450 && again.faces.length <= 1500, `${format}: ${again.faces.length}`);
    assert.equal(openEdges(again.positions, again.faces), 0, format);
  }
});

test('files are read and written gzipped', async () => {
  const { bytes, files } = await simplify({ name: 'spot.ply.gz', bytes: gzipSync(spot) }, { ratio: 0.1 }, { out: 'light.obj.gz' });
  assert.equal(files[0].name, 'light.obj.gz');
  assert.match(new TextDecoder().decode(gunzipSync(bytes)), /^v /m);
});

test('levels of detail are files of their own', async () => {
  const { files, results } = await simplify(spot, { lods: [0.5, 0.1] }, { name: 'spot.ply', out: 'spot.ply', arrays: true });
  assert.deepEqual(files.map(({ name }) => name), ['spot-1.ply', 'spot-2.ply']);
  assert.equal(results.length, 2);
  assert.ok(results[0].faces.length > results[1].faces.length);
});

test('an OBJ comes with its materials and images', async () => {
  const mesh = unrolledTorus();
  const obj = utf8(toObj(mesh, { head: 'mtllib paint.mtl', material: 'usemtl red' }));
  const beside = { 'paint.mtl': utf8('newmtl red\nKd 1 0 0\nmap_Kd maps/red.png\n'), 'maps/red.png': PIXEL };
  const { files: [written], bytes } = await simplify(obj, { ratio: 0.2 }, { name: 'torus.obj', beside });
  assert.match(new TextDecoder().decode(bytes), /^mtllib /m);
  assert.ok(written.beside.some(({ name }) => name.endsWith('.mtl')), `${written.beside.map(({ name }) => name)}`);
  const list = Object.entries(beside).map(([name, file]) => ({ name, bytes: file }));
  const { bytes: glb } = await simplify({ name: 'torus.obj', bytes: obj, beside: list }, { ratio: 0.2 }, { out: 'torus.glb' });
  const { mesh: drawn } = await look(glb, { name: 'torus.glb' });
  assert.equal(drawn.groups.length, 1);
  assert.deepEqual(drawn.groups[0].image, PIXEL);
  assert.equal(drawn.uv.length, (2 * drawn.positions.length) / 3);
});

test('look gives the finish of materials that are more than a colour', async () => {
  const obj = utf8(toObj(unrolledTorus(), { head: 'mtllib paint.mtl', material: 'usemtl red' }));
  const finishOf = async (statements) => {
    const beside = { 'paint.mtl': utf8(`newmtl red\nKd 1 0 0\n${statements}`), 'maps/red.png': PIXEL };
    return (await look({ name: 'torus.obj', bytes: obj, beside })).mesh.groups[0].finish;
  };
  assert.equal(await finishOf(''), undefined);
  const { metal, roughness, maps } = await finishOf('Pm 0.5\nnorm maps/red.png\n');
  assert.deepEqual([metal, roughness, maps], [0.5, 1, { normal: PIXEL }]);
});

test('look gives a surface to draw', async () => {
  const { mesh, notes } = await look(spot, { name: 'spot.ply' });
  assert.ok(Array.isArray(notes));
  assert.ok(mesh.faces.every((vertex) => vertex < mesh.positions.length / 3));
  assert.equal(mesh.groups.reduce((sum, { faces: n }) => sum + n, 0), mesh.faces.length / 3);
  assert.equal(mesh.origin.length, 3);
  assert.ok(Math.abs(Math.hypot(...mesh.eye) - 1) < 1e-5);
});

test('compare measures distances', async () => {
  const { bytes } = await simplify(spot, { ratio: 0.1 }, { name: 'spot.ply' });
  const { comparison, surfaces, distances } = await compare({ name: 'spot.ply', bytes: spot }, { name: 'light.ply', bytes }, { samples: 2000 });
  assert.equal(typeof comparison, 'object');
  assert.equal(comparison.results[0].name, 'light.ply');
  assert.deepEqual([surfaces.length, distances.length], [2, 1]);
  assert.ok(surfaces[1].faces.length < surfaces[0].faces.length);
  assert.ok(distances[0].of_original.every((d) => d >= 0 && d < 0.1));
});

test('broken files are one line, and the next call works', async () => {
  const { bytes: glb } = await simplify({ positions, faces }, { ratio: 0.5 }, { out: 'a.glb' });
  const { bytes: stl } = await simplify({ positions, faces }, { ratio: 0.5 }, { out: 'a.stl' });
  const broken = [
    ['a.glb', glb.slice(0, 100)], ['a.glb', glb.slice(0, 20)], ['a.stl', stl.slice(0, 50)],
    ['a.ply', utf8('ply\n')], ['a.obj', new Uint8Array(0)], ['a.xyz', utf8('?')],
  ];
  for (const worker of [true, false]) {
    for (const [name, bytes] of broken) {
      await assert.rejects(simplify(bytes, { ratio: 0.5 }, { name, worker }), oneLine, name);
    }
    assert.ok((await simplify({ positions, faces }, { ratio: 0.5 }, { worker })).results.length === 1);
  }
});

test('options are checked by the program', async () => {
  await assert.rejects(simplify({ positions, faces }, { rato: 0.5 }), { ...oneLine, message: /rato/ });
  await assert.rejects(simplify({ positions, faces }, {}), oneLine);
  await assert.rejects(simplify({ positions, faces }, { ratio: 0.5, faces: 10 }), oneLine);
  await assert.rejects(simplify({ positions, faces }, { ratio: 'much' }), oneLine);
  await assert.rejects(simplify(5, { ratio: 0.5 }), { name: 'TypeError' });
  await assert.rejects(simplify({ positions, indices: faces }, { ratio: 0.5 }), { name: 'TypeError', message: /^indices: name them faces/ });
  await assert.rejects(simplify({ positions, faces: [[0, 1, 2]] }, { ratio: 0.5 }), { name: 'TypeError', message: /faces\.flat/ });
  await assert.rejects(simplify(new TextEncoder().encode('v 0 0 0\n'), { ratio: 0.5 }), { name: 'TypeError', message: /third argument/ });
});

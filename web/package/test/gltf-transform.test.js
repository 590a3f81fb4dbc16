// Tests `neuralSimplify` on documents of glTF-Transform with skins, morph targets and materials; and `NeuralSimplifier` in
// glTF-Transform's own `simplify`.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Document, NodeIO } from '@gltf-transform/core';
import { KHRMeshQuantization } from '@gltf-transform/extensions';
import { simplify, weld } from '@gltf-transform/functions';
import { MeshoptSimplifier } from 'meshoptimizer';

import { built } from './built.js';
import { openEdges, torus, unrolledTorus } from './shapes.js';
import { spot } from './spot.js';

const { neuralSimplify } = await built('gltf-transform');
const { NeuralSimplifier } = await built('simplifier');
const silent = { debug() {}, info() {}, warn() {}, error() {} };

/** Creates a document with a torus of two primitives that share vertices, with a skin, a morph target and materials. */
function makeDocument() {
  const document = new Document().setLogger(silent);
  const buffer = document.createBuffer();
  const { positions, normals, uv, faces } = unrolledTorus();
  const n = positions.length / 3;
  const accessor = (type, array, normalized = false) => document.createAccessor('', buffer).setType(type).setArray(array).setNormalized(normalized);
  const attributes = {
    POSITION: accessor('VEC3', positions),
    NORMAL: accessor('VEC3', normals),
    TEXCOORD_0: accessor('VEC2', uv),
    TEXCOORD_1: accessor('VEC2', uv.slice()),
    COLOR_0: accessor('VEC4', new Uint8Array(4 * n).fill(128), true),
    JOINTS_0: accessor('VEC4', Uint8Array.from({ length: 4 * n }, (_, i) => (i % 4 ? 0 : Math.floor(i / 4) % 2))),
    WEIGHTS_0: accessor('VEC4', Float32Array.from({ length: 4 * n }, (_, i) => (i % 4 ? 0 : 1))),
    _NUMBER: accessor('SCALAR', Float32Array.from({ length: n }, (_, i) => i)),
  };
  const mesh = document.createMesh('torus').setWeights([0]);
  for (const [i, half] of [faces.subarray(0, faces.length / 2), faces.subarray(faces.length / 2)].entries()) {
    const primitive = document.createPrimitive().setIndices(accessor('SCALAR', half.slice())).setMaterial(document.createMaterial(`m${i}`));
    for (const [name, attribute] of Object.entries(attributes)) primitive.setAttribute(name, attribute);
    primitive.addTarget(document.createPrimitiveTarget().setAttribute('POSITION', accessor('VEC3', positions.map((x) => x * 0.1))));
    mesh.addPrimitive(primitive);
  }
  const joints = [document.createNode('a'), document.createNode('b')];
  const skin = document.createSkin().addJoint(joints[0]).addJoint(joints[1]);
  const node = document.createNode('body').setMesh(mesh).setSkin(skin);
  document.createScene().addChild(node).addChild(joints[0]).addChild(joints[1]);
  return { document, mesh, node, skin, positions, uv };
}

/** Returns the positions and faces of all primitives of a mesh. */
function surfaceOf(mesh) {
  const [positions, faces] = [[], []];
  for (const primitive of mesh.listPrimitives()) {
    const from = positions.length / 3;
    const element = [];
    const position = primitive.getAttribute('POSITION');
    for (let i = 0; i < position.getCount(); i++) positions.push(...position.getElement(i, element));
    for (const index of primitive.getIndices().getArray()) faces.push(from + index);
  }
  return { positions, faces };
}

test('a document becomes lighter in place and stays joined', async () => {
  const { document, mesh, node, skin, positions, uv } = makeDocument();
  const before = surfaceOf(mesh).faces.length;
  await document.transform(neuralSimplify({ ratio: 0.25, move: false }));
  const after = surfaceOf(mesh);
  assert.ok(after.faces.length <= 0.25 * before && after.faces.length > 0.2 * before, `${after.faces.length} of ${before}`);
  assert.equal(openEdges(after.positions, after.faces), 0);
  assert.equal(node.getMesh(), mesh);
  assert.equal(node.getSkin(), skin);
  assert.deepEqual(mesh.listPrimitives().map((primitive) => primitive.getMaterial().getName()), ['m0', 'm1']);
  for (const primitive of mesh.listPrimitives()) {
    const number = primitive.getAttribute('_NUMBER');
    const element = [];
    for (let i = 0; i < number.getCount(); i++) {
      const origin = number.getScalar(i);
      assert.deepEqual(primitive.getAttribute('POSITION').getElement(i, element), [...positions.subarray(3 * origin, 3 * origin + 3)]);
      assert.deepEqual(primitive.getAttribute('TEXCOORD_1').getElement(i, []), [...uv.subarray(2 * origin, 2 * origin + 2)]);
      assert.equal(primitive.getAttribute('JOINTS_0').getElement(i, [])[0], origin % 2);
      assert.equal(primitive.listTargets()[0].getAttribute('POSITION').getElement(i, [])[0], Math.fround(positions[3 * origin] * 0.1));
    }
    assert.ok(primitive.getAttribute('COLOR_0').getArray() instanceof Uint8Array && primitive.getAttribute('COLOR_0').getNormalized());
  }
});

test('what moves takes its attributes along', async () => {
  const { document, mesh } = makeDocument();
  const before = surfaceOf(mesh).faces.length;
  await document.transform(neuralSimplify({ ratio: 0.1 }));
  const after = surfaceOf(mesh);
  assert.ok(after.faces.length <= 0.1 * before && after.faces.length > 0.08 * before, `${after.faces.length} of ${before}`);
  assert.equal(openEdges(after.positions, after.faces), 0);
  for (const primitive of mesh.listPrimitives()) {
    const get = (name, i) => primitive.getAttribute(name).getElement(i, []);
    for (let i = 0; i < primitive.getAttribute('POSITION').getCount(); i++) {
      const [x, y, z] = get('POSITION', i);
      assert.ok(Math.abs(Math.hypot(...get('NORMAL', i)) - 1) < 1e-5);
      assert.ok(Math.abs((Math.hypot(x, y) - 2) ** 2 + z ** 2 - 1) < 0.3, 'near the torus');
      assert.ok(Math.abs(primitive.listTargets()[0].getAttribute('POSITION').getElement(i, [])[0] - 0.1 * x) < 0.03);
      assert.ok(Math.abs(get('TEXCOORD_0', i)[0] - get('TEXCOORD_1', i)[0]) < 1e-6);
      assert.ok(Number.isInteger(get('_NUMBER', i)[0]) && get('JOINTS_0', i)[0] === get('_NUMBER', i)[0] % 2);
    }
  }
});

test('what no one uses any more is gone, and the document can be written', async () => {
  const { document } = makeDocument();
  await document.transform(neuralSimplify({ ratio: 0.25 }));
  assert.ok(document.getRoot().listAccessors().every((accessor) => accessor.listParents().length > 1));
  const bytes = await new NodeIO().setLogger(silent).writeBinary(document);
  const again = await new NodeIO().setLogger(silent).readBinary(bytes);
  assert.equal(again.getRoot().listMeshes()[0].listPrimitives().length, 2);
});

test('primitives keep what they look like, and stay joined where they are few', async () => {
  const { positions, faces } = torus();
  const nParts = 24;
  // With jagged borders and fixed vertices, some corners use vertices that their primitive did not have.
  for (const [move, jag] of [[true, 0], [false, 0.03]]) {
    const document = new Document().setLogger(silent);
    const mesh = document.createMesh();
    const lists = Array.from({ length: nParts }, () => []);
    for (let i = 0; i < faces.length; i += 3) {
      const sector = Math.atan2(positions[3 * faces[i] + 1], positions[3 * faces[i]]) / (2 * Math.PI) + 0.5 + jag * (i % 7);
      lists[Math.max(0, Math.min(nParts - 1, Math.floor(sector * nParts)))].push(...faces.subarray(i, i + 3));
    }
    lists.forEach((list, part) => {
      const vertices = [...new Set(list)];
      const accessor = (type, array) => document.createAccessor().setType(type).setArray(array);
      mesh.addPrimitive(document.createPrimitive()
        .setIndices(accessor('SCALAR', Uint16Array.from(list, (vertex) => vertices.indexOf(vertex))))
        .setAttribute('POSITION', accessor('VEC3', Float32Array.from(vertices.flatMap((v) => [...positions.subarray(3 * v, 3 * v + 3)]))))
        .setAttribute('TEXCOORD_0', accessor('VEC2', new Float32Array(2 * vertices.length).fill(part)))
        .setAttribute('_NUMBER', accessor('SCALAR', Float32Array.from(vertices))));
    });
    await document.transform(neuralSimplify({ ratio: 0.05, move }));
    const after = surfaceOf(mesh);
    assert.equal(openEdges(after.positions, after.faces), 0);
    const looks = (primitive) => new Set(primitive.getAttribute('TEXCOORD_0').getArray().map((x) => Math.round(1e3 * x) / 1e3));
    const parts = mesh.listPrimitives().map((primitive) => [...looks(primitive)]);
    assert.ok(parts.every(({ length }) => length === 1) && new Set(parts.flat()).size === parts.length, `${parts}`);
    for (const primitive of move ? [] : mesh.listPrimitives()) {
      const numbers = primitive.getAttribute('_NUMBER').getArray();
      const expected = [...numbers].flatMap((vertex) => [...positions.subarray(3 * vertex, 3 * vertex + 3)]);
      assert.deepEqual([...primitive.getAttribute('POSITION').getArray()], expected);
    }
    assert.ok(document.getRoot().listAccessors().every((one) => one.listParents().length > 1));
  }
});

test('accessors that other meshes use stay', async () => {
  const { document, mesh } = makeDocument();
  const [first, second] = mesh.listPrimitives();
  mesh.removePrimitive(second);
  second.setMode(0);
  document.createMesh('points').addPrimitive(second);
  const position = second.getAttribute('POSITION');
  const n = position.getCount();
  await document.transform(neuralSimplify({ ratio: 0.25 }));
  assert.equal(second.getAttribute('POSITION'), position);
  assert.equal(position.getCount(), n);
  assert.ok(first.getAttribute('POSITION').getCount() < n / 2);
});

test('small numbers stay small numbers', async () => {
  const { document, mesh, positions } = makeDocument();
  document.createExtension(KHRMeshQuantization).setRequired(true);
  for (const primitive of mesh.listPrimitives()) {
    const position = primitive.getAttribute('POSITION');
    if (!position.getNormalized()) position.setNormalized(true).setArray(Int16Array.from(positions, (x) => Math.round(8000 * x)));
  }
  const before = surfaceOf(mesh).faces.length;
  await document.transform(neuralSimplify({ ratio: 0.25 }));
  assert.ok(surfaceOf(mesh).faces.length <= 0.25 * before);
  assert.ok(mesh.listPrimitives()[0].getAttribute('POSITION').getArray() instanceof Int16Array);
  await new NodeIO().setLogger(silent).registerExtensions([KHRMeshQuantization]).writeBinary(document);
});

test('strips and fans become triangles', async () => {
  for (const mode of [5, 6]) {
    const document = new Document().setLogger(silent);
    const n = 40;
    const points = Array.from({ length: n }, (_, i) => (mode === 5
      ? [Math.floor(i / 2), i % 2, 0]
      : i === 0 ? [0, 0, 0] : [Math.cos((2 * i) / n), Math.sin((2 * i) / n), 0]));
    const position = document.createAccessor().setType('VEC3').setArray(Float32Array.from(points.flat()));
    const primitive = document.createPrimitive().setMode(mode).setAttribute('POSITION', position);
    const mesh = document.createMesh().addPrimitive(primitive);
    await document.transform(neuralSimplify({ ratio: 1 }));
    assert.equal(primitive.getMode(), 4);
    const { positions, faces } = surfaceOf(mesh);
    assert.equal(faces.length, 3 * (n - 2));
    const normals = new Set();
    for (let i = 0; i < faces.length; i += 3) {
      const [a, b, c] = [0, 1, 2].map((j) => positions.slice(3 * faces[i + j], 3 * faces[i + j] + 2));
      normals.add(Math.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])));
    }
    assert.equal(normals.size, 1, 'all run the same way round');
  }
});

test('progress, signal and options', async () => {
  const shares = [];
  await makeDocument().document.transform(neuralSimplify({ faces: 500, progress: (share) => shares.push(share) }));
  assert.ok(shares.every((share) => share >= 0 && share <= 1));
  await assert.rejects(makeDocument().document.transform(neuralSimplify({ ratio: 0.5, signal: AbortSignal.abort() })), { name: 'AbortError' });
  assert.throws(() => neuralSimplify({}), { name: 'TypeError' });
  assert.throws(() => neuralSimplify({ ratio: -1 }), { name: 'RangeError' });
});

test('a failure leaves the document as it is', async () => {
  const { document, mesh } = makeDocument();
  document.createMesh('second').addPrimitive(mesh.listPrimitives()[0].clone());
  const abort = new AbortController();
  const before = surfaceOf(mesh).faces;
  const running = document.transform(neuralSimplify({ ratio: 0.25, signal: abort.signal }));
  abort.abort();
  await assert.rejects(running, { name: 'AbortError' });
  assert.deepEqual(surfaceOf(mesh).faces, before);
});

test('NeuralSimplifier serves simplify of glTF-Transform', async () => {
  const { document, mesh } = makeDocument();
  const before = surfaceOf(mesh).faces.length;
  await document.transform(weld(), simplify({ simplifier: NeuralSimplifier, ratio: 0.5, error: 0.01 }));
  const after = surfaceOf(mesh).faces.length;
  assert.ok(after <= 0.5 * before && after > 0.3 * before, `${after} of ${before}`);
});

test('the default of glTF-Transform, an error without a size, simplifies as with MeshoptSimplifier', async () => {
  await MeshoptSimplifier.ready;
  const { positions, faces } = spot();
  const left = [];
  for (const simplifier of [MeshoptSimplifier, NeuralSimplifier]) {
    const document = new Document().setLogger(silent);
    const accessor = (type, array) => document.createAccessor('', document.getRoot().listBuffers()[0] ?? document.createBuffer()).setType(type).setArray(array);
    const primitive = document.createPrimitive().setAttribute('POSITION', accessor('VEC3', positions.slice())).setIndices(accessor('SCALAR', faces.slice()));
    document.createMesh().addPrimitive(primitive);
    await document.transform(weld(), simplify({ simplifier }));
    left.push(primitive.getIndices().getCount() / 3);
  }
  const [theirs, ours] = left;
  assert.ok(ours <= theirs && ours > 0.9 * theirs && theirs < faces.length / 3, `${ours} and ${theirs}`);
});

// Tests `simplifyModifier`: the result has all attributes, morph attributes and groups, and the input is unchanged.

import assert from 'node:assert/strict';
import test from 'node:test';
import {
  BoxGeometry, BufferAttribute, BufferGeometry, Float32BufferAttribute, InterleavedBuffer, InterleavedBufferAttribute, SphereGeometry,
  TorusGeometry, TorusKnotGeometry,
} from 'three';

import { built } from './built.js';
import { openEdges } from './shapes.js';

const { simplifyModifier } = await built('three');
const counts = (geometry) => (geometry.index?.count ?? geometry.attributes.position.count) / 3;

/** Finds the vertex of `source` with all attributes equal to those of a vertex of `light`. */
function originOf(light, source, vertex) {
  const names = Object.keys(source.attributes);
  const numbers = (attribute, i) => Array.from({ length: attribute.itemSize }, (_, j) => attribute.getComponent(i, j));
  const row = ({ attributes }, i) => names.map((name) => numbers(attributes[name], i)).flat().join();
  const wanted = row(light, vertex);
  for (let i = 0; i < source.attributes.position.count; i++) if (row(source, i) === wanted) return i;
  return -1;
}

test('geometries of three.js become lighter', async () => {
  for (const geometry of [new TorusKnotGeometry(1, 0.3, 128, 24), new SphereGeometry(1, 48, 32), new TorusGeometry(2, 1, 24, 48)]) {
    const light = await simplifyModifier(geometry, { ratio: 0.25, move: false });
    assert.ok(light.isBufferGeometry && light.index);
    const share = counts(light) / counts(geometry);
    assert.ok(share <= 0.25 && share > 0.2, `${geometry.type}: ${share}`);
    assert.deepEqual(Object.keys(light.attributes), Object.keys(geometry.attributes));
    for (let i = 0; i < light.attributes.position.count; i += 7) assert.notEqual(originOf(light, geometry, i), -1);
  }
});

test('the given geometry stays, and so do all kinds of attributes', async () => {
  const geometry = new TorusKnotGeometry(1, 0.3, 64, 16);
  const n = geometry.attributes.position.count;
  geometry.setAttribute('skinIndex', new BufferAttribute(Uint16Array.from({ length: 4 * n }, (_, i) => i % 5), 4));
  geometry.setAttribute('skinWeight', new BufferAttribute(Uint8Array.from({ length: 4 * n }, (_, i) => (i % 4 ? 0 : 255)), 4, true));
  geometry.setAttribute('number', new Float32BufferAttribute(Float32Array.from({ length: n }, (_, i) => i), 1));
  geometry.morphAttributes.position = [geometry.attributes.position.clone()];
  geometry.morphTargetsRelative = true;
  geometry.userData = { of: 'mine' };
  const before = JSON.stringify(geometry.toJSON());
  const light = await simplifyModifier(geometry, { ratio: 0.3, move: false });
  assert.equal(JSON.stringify(geometry.toJSON()), before);
  assert.ok(light.attributes.skinIndex.array instanceof Uint16Array);
  assert.ok(light.attributes.skinWeight.normalized && light.attributes.skinWeight.array instanceof Uint8Array);
  assert.equal(light.morphTargetsRelative, true);
  assert.deepEqual(light.userData, { of: 'mine' });
  for (let i = 0; i < light.attributes.position.count; i++) {
    const origin = light.attributes.number.getX(i);
    assert.equal(light.attributes.position.getX(i), geometry.attributes.position.getX(origin));
    assert.equal(light.morphAttributes.position[0].getY(i), geometry.attributes.position.getY(origin));
    assert.equal(light.attributes.skinIndex.getX(i), (4 * origin) % 5);
  }
});

test('what moves takes its attributes along', async () => {
  const geometry = new SphereGeometry(1, 48, 32);
  const n = geometry.attributes.position.count;
  const wide = (factor) => new Float32BufferAttribute(geometry.attributes.position.array.map((x) => factor * x), 3);
  const colors = Uint8Array.from(geometry.attributes.position.array, (x) => Math.round(127 * (x + 1)));
  geometry.setAttribute('color', new BufferAttribute(colors, 3, true));
  geometry.setAttribute('skinIndex', new BufferAttribute(Uint16Array.from({ length: 4 * n }, (_, i) => i % 5), 4));
  for (const [isRelative, factor] of [[true, 0.5], [false, 1.5]]) {
    geometry.morphTargetsRelative = isRelative;
    geometry.morphAttributes.position = [wide(factor)];
    const light = await simplifyModifier(geometry, { ratio: 0.2 });
    const { position, normal, color, skinIndex } = light.attributes;
    for (let i = 0; i < position.count; i++) {
      const length = Math.hypot(position.getX(i), position.getY(i), position.getZ(i));
      assert.ok(Math.abs(length - 1) < 0.05, `${length}`);
      assert.ok(Math.abs(Math.hypot(normal.getX(i), normal.getY(i), normal.getZ(i)) - 1) < 1e-5);
      assert.ok(Math.abs(normal.getX(i) - position.getX(i)) < 0.1 && Math.abs(2 * color.getX(i) - 1 - position.getX(i)) < 0.1);
      assert.ok(Math.abs(light.morphAttributes.position[0].getX(i) - factor * position.getX(i)) < 0.05);
      assert.equal(skinIndex.getY(i), (skinIndex.getX(i) + 1) % 5);
    }
    assert.ok(color.array instanceof Uint8Array && color.normalized);
  }
});

test('groups stay, and their faces stay theirs', async () => {
  const geometry = new BoxGeometry(1, 1, 1, 12, 12, 12);
  const light = await simplifyModifier(geometry, { ratio: 0.2 });
  assert.deepEqual(light.groups.map(({ materialIndex }) => materialIndex), [0, 1, 2, 3, 4, 5]);
  assert.equal(light.groups.reduce((sum, { count }) => sum + count, 0), light.index.count);
  const sides = [[0, 0.5], [0, -0.5], [1, 0.5], [1, -0.5], [2, 0.5], [2, -0.5]];
  light.groups.forEach(({ start, count }, side) => {
    const [axis, value] = sides[side];
    for (let i = start; i < start + count; i++) {
      assert.ok(Math.abs(light.attributes.position.getComponent(light.index.getX(i), axis) - value) < 1e-6);
    }
  });
  assert.equal(openEdges(light.attributes.position.array, light.index.array), 0);
});

test('groups may overlap and leave triangles out', async () => {
  const geometry = new TorusGeometry(2, 1, 24, 48);
  const n = geometry.index.count;
  geometry.addGroup(0, n / 2, 1);
  geometry.addGroup(n / 4, n / 2, 2);
  const light = await simplifyModifier(geometry, { ratio: 0.4 });
  const [one, two] = light.groups;
  assert.deepEqual([one.materialIndex, two.materialIndex], [1, 2]);
  assert.ok(one.start === 0 && two.start < one.count && two.start + two.count < light.index.count);
});

test('triangles that share no vertices are joined first', async () => {
  const geometry = new TorusGeometry(2, 1, 24, 48).toNonIndexed();
  const light = await simplifyModifier(geometry, { ratio: 0.25 });
  assert.ok(counts(light) <= 0.25 * counts(geometry) && light.attributes.position.count < counts(light));
});

test('interleaved attributes are read', async () => {
  const torus = new TorusGeometry(2, 1, 24, 48);
  const rows = new Float32Array(4 * torus.attributes.position.count);
  torus.attributes.position.array.forEach((x, i) => { rows[4 * Math.floor(i / 3) + (i % 3) + 1] = x; });
  const geometry = new BufferGeometry();
  geometry.setIndex(torus.index);
  geometry.setAttribute('position', new InterleavedBufferAttribute(new InterleavedBuffer(rows, 4), 3, 1));
  const light = await simplifyModifier(geometry, { ratio: 0.25 });
  const bare = new BufferGeometry().setIndex(torus.index).setAttribute('position', torus.attributes.position);
  const plain = await simplifyModifier(bare, { ratio: 0.25 });
  assert.deepEqual(light.index.array, plain.index.array);
  assert.deepEqual(light.attributes.position.array, plain.attributes.position.array);
});

test('faces, error, lockBorder, worker and signal', async () => {
  const geometry = new TorusGeometry(2, 1, 24, 48);
  assert.ok(counts(await simplifyModifier(geometry, { faces: 300 })) <= 300);
  assert.ok(counts(await simplifyModifier(geometry, { error: 0.01 })) < counts(geometry));
  const here = await simplifyModifier(geometry, { ratio: 0.25, worker: false });
  assert.deepEqual(here.index.array, (await simplifyModifier(geometry, { ratio: 0.25 })).index.array);
  await assert.rejects(simplifyModifier(geometry, { ratio: 0.25, signal: AbortSignal.abort() }), { name: 'AbortError' });
});

test('what cannot be used is refused', async () => {
  await assert.rejects(simplifyModifier({}, { ratio: 0.5 }), { name: 'TypeError', message: /^geometry: / });
  await assert.rejects(simplifyModifier(new BufferGeometry(), { ratio: 0.5 }), { name: 'TypeError', message: /^geometry: / });
  await assert.rejects(simplifyModifier(new BoxGeometry(), { ratio: 2 }), { name: 'RangeError', message: /^ratio: / });
  await assert.rejects(simplifyModifier(new BoxGeometry()), { name: 'TypeError', message: /^give / });
});

// Tests each member of `NeuralSimplifier`: results, errors, and calls after a failure.

import assert from 'node:assert/strict';
import test from 'node:test';

import { built } from './built.js';
import { hill, openEdges, torus } from './shapes.js';

const { NeuralSimplifier, simplifyIndices } = await built('simplifier');
const { positions, faces } = torus();
const none = new Float32Array(0);

/** Returns positions with extra numbers in each row, and the call without them that must have an equal result. */
function widened(rows, width, stride) {
  const wide = new Float32Array((rows.length / width) * stride).fill(NaN);
  for (let i = 0; i < rows.length; i++) wide[Math.floor(i / width) * stride + (i % width)] = rows[i];
  return wide;
}

test('members throw before ready', () => {
  assert.throws(() => NeuralSimplifier.simplify(faces, positions, 3, 300, 1), /await NeuralSimplifier.ready/);
});

test('ready is one promise', async () => {
  assert.equal(NeuralSimplifier.supported, true);
  assert.equal(NeuralSimplifier.ready, NeuralSimplifier.ready);
  await NeuralSimplifier.ready;
});

test('compactMesh numbers vertices in the order of their use', () => {
  const indices = Uint16Array.of(7, 2, 5, 5, 2, 0);
  const [remap, used] = NeuralSimplifier.compactMesh(indices);
  assert.deepEqual(indices, Uint16Array.of(0, 1, 2, 2, 1, 3));
  const gone = 0xffffffff;
  assert.deepEqual(remap, Uint32Array.of(3, gone, 1, gone, gone, 2, gone, 0));
  assert.equal(used, 4);
  assert.deepEqual(NeuralSimplifier.compactMesh(new Uint32Array(0)), [new Uint32Array(0), 0]);
});

test('generatePositionRemap finds equal positions', () => {
  const rows = Float32Array.of(0, 0, 0, 9, 1, 0, 0, 9, -0, 0, 0, 8, 1, 0, 0, 7);
  assert.deepEqual(NeuralSimplifier.generatePositionRemap(rows, 4), Uint32Array.of(0, 1, 0, 1));
});

test('getScale is the longest side of the box', () => {
  assert.equal(NeuralSimplifier.getScale(Float32Array.of(-1, 0, 0, 5, 1, 0.5, 0, 5), 4), 2);
  assert.equal(NeuralSimplifier.getScale(none, 3), 0);
});

test('simplify reaches its size and stays closed', () => {
  for (const share of [0.5, 0.2, 0.1]) {
    const target = 3 * Math.floor((faces.length / 3) * share);
    const [indices, error] = NeuralSimplifier.simplify(faces, positions, 3, target, 1);
    assert.ok(indices instanceof Uint32Array);
    assert.ok(indices.length <= target && indices.length > 0.8 * target, `${indices.length} of ${target}`);
    assert.equal(openEdges(positions, indices), 0);
    assert.ok(error > 0 && error < 0.2, `${error}`);
  }
});

test('simplify returns the class of indices that it is given', () => {
  for (const type of [Uint32Array, Int32Array, Uint16Array, Int16Array]) {
    const [indices] = NeuralSimplifier.simplify(type.from(faces), positions, 3, 600, 1);
    assert.equal(indices.constructor, type);
    assert.deepEqual([...indices], [...NeuralSimplifier.simplify(faces, positions, 3, 600, 1)[0]]);
  }
});

test('simplify sees positions and nothing else of a row', () => {
  const tight = NeuralSimplifier.simplify(faces, positions, 3, 600, 1);
  assert.deepEqual(NeuralSimplifier.simplify(faces, widened(positions, 3, 8), 8, 600, 1), tight);
});

test('simplify stops at the error', () => {
  const [few, large] = NeuralSimplifier.simplify(faces, positions, 3, 0, 0.02);
  const [many, small] = NeuralSimplifier.simplify(faces, positions, 3, 0, 0.002);
  assert.ok(few.length < many.length && many.length < faces.length, `${few.length} ${many.length}`);
  assert.ok(small <= 0.002 && large <= 0.02, `${small} ${large}`);
});

test('simplify takes an infinite error', () => {
  const [indices] = NeuralSimplifier.simplify(faces, positions, 3, 300, Infinity);
  assert.ok(indices.length > 0 && indices.length <= 300);
});

test('ErrorAbsolute counts in the unit of the mesh', () => {
  const scale = NeuralSimplifier.getScale(positions, 3);
  const relative = NeuralSimplifier.simplify(faces, positions, 3, 0, 0.01);
  const absolute = NeuralSimplifier.simplify(faces, positions, 3, 0, 0.01 * scale, ['ErrorAbsolute']);
  assert.deepEqual(absolute[0], relative[0]);
  assert.ok(Math.abs(absolute[1] - relative[1] * scale) < 1e-5);
});

test('LockBorder keeps the boundary', () => {
  const { positions: points, faces: triangles } = hill();
  const border = (indices) => {
    const edges = new Map();
    indices.forEach((a, i) => {
      const b = indices[i % 3 === 2 ? i - 2 : i + 1];
      const key = a < b ? `${a} ${b}` : `${b} ${a}`;
      edges.set(key, (edges.get(key) ?? 0) + 1);
    });
    return [...edges].filter(([, n]) => n === 1).map(([key]) => key).sort();
  };
  const [indices] = NeuralSimplifier.simplify(triangles, points, 3, 600, 1, ['LockBorder']);
  assert.deepEqual(border(indices), border(triangles));
  assert.ok(indices.length < triangles.length / 2, `${indices.length}`);
});

test('a measured error is the distance that the whole program measures', async () => {
  const { compare } = await built('index');
  const { positions: points, faces: triangles } = hill(40);
  const file = (name, rows, indices) => {
    const lines = (letter, numbers, add) => Array.from({ length: numbers.length / 3 }, (_, i) =>
      `${letter} ${[...numbers.subarray(3 * i, 3 * i + 3)].map((x) => x + add).join(' ')}\n`).join('');
    return { name, bytes: new TextEncoder().encode(lines('v', rows, 0) + lines('f', indices, 1)) };
  };
  const diagonal = Math.hypot(...[0, 1, 2].map((axis) => {
    const column = points.filter((_, i) => i % 3 === axis);
    return Math.max(...column) - Math.min(...column);
  }));
  for (const move of [false, true]) {
    const surface = { indices: triangles, positions: widened(points, 3, 4), stride: 4 };
    const goal = { target: 600, move, worker: false };
    const estimated = await simplifyIndices(surface, goal);
    const light = await simplifyIndices(surface, { ...goal, measure: true, flags: ['ErrorAbsolute'] });
    assert.deepEqual(light.indices, estimated.indices);
    const { comparison } = await compare(file('a.obj', points, triangles), file('b.obj', light.positions ?? points, light.indices), { worker: false });
    const measured = (comparison.results[0].values.distance_max / 100) * diagonal;
    assert.ok(light.error > 0.95 * measured && light.error < 1.05 * measured, `${light.error} for ${measured}`);
    const relative = await simplifyIndices(surface, { ...goal, measure: true });
    assert.ok(Math.abs(relative.error * NeuralSimplifier.getScale(points, 3) - light.error) < 1e-6);
    assert.notEqual(relative.error, estimated.error);
  }
});

test('a measured error is 0 for the mesh itself, and an estimate where nothing is left', async () => {
  const surface = { indices: faces, positions };
  assert.ok((await simplifyIndices(surface, { target: faces.length, measure: true, worker: false })).error < 1e-9);
  const nothing = await simplifyIndices(surface, { target: 0, measure: true, worker: false });
  assert.deepEqual([nothing.indices.length, nothing.error], [0, 1]);
});

test('all flags are taken', () => {
  const structure = ['LockBorder', 'Prune', 'Permissive', 'PreserveFolds'];
  for (const flag of [...structure, 'Sparse', 'ErrorAbsolute', 'ErrorClamped', 'Regularize', 'RegularizeLight']) {
    const [indices] = NeuralSimplifier.simplify(faces, positions, 3, 1200, 1, [flag]);
    assert.ok(indices.length > 0 && indices.length <= 1200, `${flag}: ${indices.length}`);
  }
});

test('simplifyWithAttributes keeps vertices that are locked', () => {
  const locks = new Uint8Array(positions.length / 3);
  for (let i = 0; i < locks.length; i += 7) locks[i] = 1;
  const [indices] = NeuralSimplifier.simplifyWithAttributes(faces, positions, 3, none, 0, [], locks, 900, 1);
  const used = new Set(indices);
  locks.forEach((lock, vertex) => assert.ok(!lock || used.has(vertex), `${vertex}`));
});

test('simplifyWithAttributes heeds attributes', () => {
  const { positions: points, faces: triangles } = hill();
  for (let i = 2; i < points.length; i += 3) points[i] = 0;
  const edge = Float32Array.from({ length: points.length / 3 }, (_, i) => (points[3 * i] > 0.5 ? 1 : 0));
  const [plain] = NeuralSimplifier.simplify(triangles, points, 3, 0, 1e-3);
  const [heeded] = NeuralSimplifier.simplifyWithAttributes(triangles, points, 3, edge, 1, [1], null, 0, 1e-3);
  assert.ok(heeded.length > plain.length, `${heeded.length} ${plain.length}`);
  const wide = widened(edge, 1, 3);
  assert.deepEqual(NeuralSimplifier.simplifyWithAttributes(triangles, points, 3, wide, 3, [1], null, 0, 1e-3)[0], heeded);
});

test('simplifyWithUpdate moves vertices in place', () => {
  const moved = widened(positions, 3, 4);
  const attributes = widened(Float32Array.from({ length: positions.length / 3 }, (_, i) => i % 5), 1, 2);
  for (const type of [Uint32Array, Uint16Array]) {
    const indices = type.from(faces);
    const points = moved.slice();
    const [n, error] = NeuralSimplifier.simplifyWithUpdate(indices, points, 4, attributes.slice(), 2, [0.1], null, 900, 1);
    assert.ok(n > 700 && n <= 900 && n % 3 === 0 && error > 0, `${n} ${error}`);
    assert.ok(points.some((x, i) => i % 4 !== 3 && x !== moved[i]));
    assert.ok(points.every((x, i) => Number.isNaN(x) === (i % 4 === 3)), 'what stands behind the positions stays');
    const tight = Float32Array.from({ length: positions.length }, (_, i) => points[4 * Math.floor(i / 3) + (i % 3)]);
    assert.equal(openEdges(tight, indices.subarray(0, n)), 0);
  }
});

test('simplifyPoints chooses points', () => {
  const chosen = NeuralSimplifier.simplifyPoints(positions, 3, 100);
  assert.ok(chosen instanceof Uint32Array && chosen.length <= 100 && chosen.length > 80);
  assert.equal(new Set(chosen).size, chosen.length);
  const colors = new Float32Array((positions.length / 3) * 4).fill(0.5);
  assert.equal(NeuralSimplifier.simplifyPoints(positions, 3, 100, colors, 4, 0.01).length, chosen.length);
  assert.equal(NeuralSimplifier.simplifyPoints(positions, 3, 0).length, 0);
});

test('simplifySloppy reaches sizes and errors', () => {
  // Four tori side by side, which join.
  const n = positions.length / 3;
  const [many, shifted] = [new Uint32Array(4 * faces.length), new Float32Array(4 * positions.length)];
  for (let k = 0; k < 4; k++) {
    many.set(faces.map((v) => v + k * n), k * faces.length);
    shifted.set(positions.map((x, i) => (i % 3 === 2 ? x + 3 * k : x)), k * positions.length);
  }
  const [indices, error] = NeuralSimplifier.simplifySloppy(many, shifted, 3, null, 240, 1);
  assert.ok(indices instanceof Uint32Array);
  assert.ok(indices.length > 0 && indices.length <= 240 && indices.every((v) => v < 4 * n), `${indices.length}`);
  assert.ok(error > 0.01 && error < 1, `${error}`);
  // Above the error nothing changes.
  assert.deepEqual(NeuralSimplifier.simplifySloppy(many, shifted, 3, null, 240, error / 2), [many, 0]);
  // More triangles are nearer.
  assert.ok(NeuralSimplifier.simplifySloppy(many, shifted, 3, null, 3000, 1)[1] < error);
});

test('simplifySloppy keeps a triangle that is locked, strides and the class of indices', () => {
  const small = Uint16Array.from(faces);
  const locks = new Uint8Array(positions.length / 3);
  const locked = faces.subarray(0, 3);
  locked.forEach((v) => { locks[v] = 1; });
  const [indices] = NeuralSimplifier.simplifySloppy(small, widened(positions, 3, 5), 5, locks, 300, 1);
  assert.ok(indices instanceof Uint16Array);
  assert.ok(locked.every((v) => indices.includes(v)));
  assert.deepEqual(indices, Uint16Array.from(NeuralSimplifier.simplifySloppy(faces, positions, 3, locks, 300, 1)[0]));
  assert.throws(() => NeuralSimplifier.simplifySloppy(faces, positions, 3, new Uint8Array(3), 300, 1), /vertex_lock/);
});

test('simplifyPrune drops small components', () => {
  const small = torus(6, 5);
  const both = Float32Array.from([...positions, ...small.positions.map((x) => 0.01 * x + 9)]);
  const indices = Uint16Array.from([...faces, ...small.faces.map((i) => i + positions.length / 3)]);
  const kept = NeuralSimplifier.simplifyPrune(indices, both, 3, 0.05);
  assert.deepEqual(kept, Uint16Array.from(faces));
});

test('arguments out of range are refused by name', () => {
  const refused = (name, call) => assert.throws(call, { name: 'TypeError', message: new RegExp(`^${name}: [^\n]+$`) });
  const { simplify, simplifyWithAttributes, simplifyPoints, simplifyPrune, compactMesh, getScale } = NeuralSimplifier;
  refused('indices', () => simplify([...faces], positions, 3, 300, 1));
  refused('indices', () => simplify(faces.subarray(1), positions, 3, 300, 1));
  refused('indices', () => simplify(Uint32Array.of(0, 1, 4), new Float32Array(12), 3, 0, 1));
  refused('indices', () => compactMesh(Uint8Array.of(0, 1, 2)));
  refused('vertex_positions', () => simplify(faces, [...positions], 3, 300, 1));
  refused('vertex_positions', () => getScale(new Float32Array(7), 3));
  refused('vertex_positions_stride', () => simplify(faces, positions, 2, 300, 1));
  refused('target_index_count', () => simplify(faces, positions, 3, 301, 1));
  refused('target_index_count', () => simplify(faces, positions, 3, -3, 1));
  refused('target_index_count', () => simplify(faces, positions, 3, faces.length + 3, 1));
  refused('target_error', () => simplify(faces, positions, 3, 300, -1));
  refused('target_error', () => simplify(faces, positions, 3, 300));
  refused('flags', () => simplify(faces, positions, 3, 300, 1, ['Nothing']));
  const n = positions.length / 3;
  refused('vertex_attributes', () => simplifyWithAttributes(faces, positions, 3, new Float32Array(n - 1), 1, [1], null, 300, 1));
  refused('attribute_weights', () => simplifyWithAttributes(faces, positions, 3, new Float32Array(n), 1, [1, 1], null, 300, 1));
  refused('attribute_weights', () => simplifyWithAttributes(faces, positions, 3, new Float32Array(n), 1, [-1], null, 300, 1));
  refused('vertex_lock', () => simplifyWithAttributes(faces, positions, 3, none, 0, [], new Uint8Array(3), 300, 1));
  refused('target_vertex_count', () => simplifyPoints(positions, 3, n + 1));
  refused('vertex_colors', () => simplifyPoints(positions, 3, 10, new Float32Array(6), 3, 0));
  refused('target_error', () => simplifyPrune(faces, positions, 3));
});

test('what the program refuses is one line, and the next call works', () => {
  const broken = positions.slice();
  broken[0] = NaN;
  try {
    NeuralSimplifier.simplify(faces, broken, 3, 300, 1);
  } catch (error) {
    assert.match(`${error.name}: ${error.message}`, /^NeuralMeshError: [^\n]+$/);
  }
  assert.ok(NeuralSimplifier.simplify(faces, positions, 3, 300, 1)[0].length > 0);
});

test('simplifyIndices does the same in a worker and here', async () => {
  const [indices, error] = NeuralSimplifier.simplify(faces, positions, 3, 600, 1);
  for (const worker of [true, false]) {
    const shares = [];
    const result = await simplifyIndices({ indices: faces, positions }, { target: 600, worker, progress: (share) => shares.push(share) });
    assert.deepEqual(result, { indices, error });
    assert.ok(shares.every((share) => share >= 0 && share <= 1));
  }
  const [points, attributes] = [positions.slice(), Float32Array.from({ length: positions.length / 3 }, (_, i) => i % 7)];
  const inPlace = faces.slice();
  const moved = await simplifyIndices({ indices: faces, positions, attributes, attributesStride: 1, weights: [0.1] }, { target: 600, move: true });
  const [n] = NeuralSimplifier.simplifyWithUpdate(inPlace, points, 3, attributes, 1, [0.1], null, 600, Infinity);
  assert.deepEqual(moved.indices, inPlace.slice(0, n));
  assert.deepEqual([moved.positions, moved.attributes], [points, attributes]);
  await assert.rejects(simplifyIndices({ indices: faces, positions }, { target: 601 }), { name: 'TypeError' });
});

/** Returns a torus of `n` rings of faces, each a group with its own vertices, and the group of each vertex. */
function striped(n) {
  const points = [];
  const indices = new Uint32Array(faces.length);
  const groups = Uint32Array.from({ length: faces.length / 3 }, (_, face) => Math.floor((face * n * 3) / faces.length));
  const [owners, known] = [[], new Map()];
  faces.forEach((vertex, corner) => {
    const group = groups[Math.floor(corner / 3)];
    const key = `${group} ${vertex}`;
    if (!known.has(key)) {
      known.set(key, owners.push(group) - 1);
      points.push(...positions.subarray(3 * vertex, 3 * vertex + 3));
    }
    indices[corner] = known.get(key);
  });
  return { indices, positions: Float32Array.from(points), groups, owners };
}

test('simplifyIndices keeps groups, whose triangles use their vertices', async () => {
  const { owners, ...surface } = striped(6);
  for (const move of [true, false]) {
    for (const share of [0.5, 0.1]) {
      const target = 3 * Math.floor((share * faces.length) / 3);
      const { indices, groups, positions: points = surface.positions } = await simplifyIndices(surface, { target, move });
      assert.ok(indices.length <= target && indices.length > 0.8 * target, `${indices.length} of ${target}`);
      assert.equal(groups.length, indices.length / 3);
      assert.deepEqual([...new Set(groups)].sort(), [0, 1, 2, 3, 4, 5]);
      assert.ok(indices.every((vertex, corner) => owners[vertex] === groups[Math.floor(corner / 3)]), `${move} ${share}`);
      assert.equal(openEdges(points, indices), 0);
    }
  }
  await assert.rejects(simplifyIndices({ ...surface, groups: new Uint32Array(3) }, { target: 300 }), { name: 'TypeError', message: /^groups: / });
});

test('what has no area has no triangles', async () => {
  for (const move of [true, false]) {
    const surface = { indices: Uint32Array.of(0, 0, 1), positions: new Float32Array(6), groups: Uint32Array.of(0) };
    const { indices, error, groups } = await simplifyIndices(surface, { target: 0, move });
    assert.deepEqual([indices.length, error, groups.length], [0, 0, 0]);
  }
  const indices = Uint32Array.of(0, 0, 1);
  assert.deepEqual(NeuralSimplifier.simplifyWithUpdate(indices, new Float32Array(6), 3, new Float32Array(2), 1, [1], null, 0, 1), [0, 0]);
});

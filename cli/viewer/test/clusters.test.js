// Hierarchies of clusters without a browser: reading, cuts while pages load, damage.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { entriesOf, readHierarchy, readPage } from '../src/clusters/container.js';
import { coarseGroups, isDrawn, isInView, replacedGroups } from '../src/clusters/cut.js';
import { decodePage } from '../src/clusters/page.js';
import { hasRoots, isComplete, isWaiting, makeStore, want } from '../src/clusters/store.js';
import { NMC, naiveCut, oddEdges } from './hierarchy.js';

const open = (bytes = NMC) => readHierarchy(new Blob([bytes]));
const viewFrom = (angle) => ({ eye: [1.5 * Math.sin(angle), 0.2, 1.5 * Math.cos(angle)], pixels: 800, near: 0.01, planes: [] });

function drawnClusters(hierarchy, view, pixels, isLoaded) {
  const replaced = replacedGroups(hierarchy, coarseGroups(hierarchy, view, pixels), isLoaded);
  return [...Array(hierarchy.clusters.n).keys()].filter((cluster) => isDrawn(hierarchy, replaced, cluster));
}

/** Returns 9 numbers for each triangle of clusters. */
async function trianglesOf(hierarchy, clusters) {
  const [wanted, triangles] = [new Set(clusters), []];
  for (let page = 0; page < hierarchy.header.pages.count; page++) {
    const { contents, positions, corners, firsts } = decodePage(hierarchy, page, await readPage(hierarchy, page));
    contents.forEach((cluster, i) => {
      if (!wanted.has(cluster)) return;
      for (const v of corners.subarray(firsts[i], firsts[i + 1])) triangles.push(...positions.subarray(3 * v, 3 * v + 3));
    });
  }
  return triangles;
}

test('clusters that decide alone are those of a walk from the root, and close the surface', async () => {
  const hierarchy = await open();
  const counts = [];
  for (const [turn, pixels] of [0.1, 1, 3, 10, 30, 100, 1e6].entries()) {
    const drawn = drawnClusters(hierarchy, viewFrom(turn), pixels, () => true);
    assert.deepEqual(new Set(drawn), naiveCut(hierarchy, viewFrom(turn), pixels));
    const triangles = await trianglesOf(hierarchy, drawn);
    assert.equal(oddEdges(triangles), 0, `${pixels} pixels`);
    counts.push(triangles.length / 9);
  }
  assert.equal(counts[0], 5856);
  assert.ok(counts.at(-1) <= 32 && counts.at(-1) > 0, counts);
});

test('the surface is closed whatever is loaded', async () => {
  const hierarchy = await open();
  const sizes = new Set();
  for (let seed = 1; seed < 20; seed++) {
    // Some groups are complete, by a hash of their numbers.
    const isLoaded = (group) => ((group + 1) * 2654435761 * seed) % 97 < 5 * seed;
    const drawn = drawnClusters(hierarchy, viewFrom(seed), 0.5, isLoaded);
    for (const cluster of drawn) {
      const group = hierarchy.clusters.groups[cluster];
      assert.ok(group === 0xffffffff || isLoaded(group));
    }
    assert.equal(oddEdges(await trianglesOf(hierarchy, drawn)), 0, `seed ${seed}`);
    sizes.add(drawn.length);
  }
  assert.ok(sizes.size > 3, `${[...sizes]}`);
});

test('only clusters without a vertex in the view are left out', async () => {
  const hierarchy = await open();
  const pages = await Promise.all(Array.from({ length: hierarchy.header.pages.count }, (_, page) => readPage(hierarchy, page)));
  const decoded = pages.map((bytes, page) => decodePage(hierarchy, page, bytes));
  let [nSeen, nLeftOut] = [0, 0];
  for (let turn = 0; turn < 12; turn++) {
    // A wedge of two planes through a point of the mesh.
    const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
    const planes = [[cosine, 0, sine, -0.1], [-sine, 0.3, cosine, 0.05]].map((plane) => plane.map((x) => x / Math.hypot(...plane.slice(0, 3))));
    for (const { contents, positions, corners, firsts } of decoded) {
      contents.forEach((cluster, i) => {
        const isInside = (v) => planes.every(([a, b, c, d]) => a * positions[3 * v] + b * positions[3 * v + 1] + c * positions[3 * v + 2] + d >= 0);
        const isSeen = isInView(hierarchy.clusters, cluster, planes);
        if (corners.subarray(firsts[i], firsts[i + 1]).some(isInside)) assert.ok(isSeen, `cluster ${cluster}`);
        if (isSeen) nSeen++;
        else nLeftOut++;
      });
    }
  }
  assert.ok(nLeftOut > nSeen / 4, `${nSeen} ${nLeftOut}`);
});

test('the corners of a cluster are sorted by paint', async () => {
  const hierarchy = await open();
  // The file has no materials, so a paint is chosen by the number of the call.
  let nCalls = 0;
  const order = { nPaints: 3, paintOf: () => nCalls++ % 3, isVUp: false };
  const bytes = await readPage(hierarchy, 0);
  const [plain, sorted] = [decodePage(hierarchy, 0, bytes), decodePage(hierarchy, 0, bytes, order)];
  const faces = ({ corners }, from, to) => Array.from({ length: (to - from) / 3 }, (_, i) => corners.subarray(from + 3 * i, from + 3 * i + 3).join(' '));
  let firstFace = 0;
  plain.contents.forEach((_, i) => {
    const all = faces(plain, plain.firsts[i], plain.firsts[i + 1]);
    for (let paint = 0; paint < 3; paint++) {
      const expected = all.filter((_, face) => (firstFace + face) % 3 === paint);
      assert.deepEqual(faces(sorted, sorted.firsts[3 * i + paint], sorted.firsts[3 * i + paint + 1]), expected);
    }
    firstFace += all.length;
  });
});

/** Creates a store that records which pages it holds. */
function makeRecordingStore(hierarchy, budget) {
  const [held, errors] = [new Set(), []];
  const store = makeStore(hierarchy, budget, {
    arrived: (page) => held.add(page), dropped: (page) => held.delete(page), failed: (error) => errors.push(error.message),
  });
  return { store, held, errors };
}

async function settle(store, groups) {
  want(store, groups);
  while (isWaiting(store)) await new Promise((resolve) => setTimeout(resolve));
}

test('pages are loaded when they are needed, and dropped beyond the budget', async () => {
  const hierarchy = await open();
  assert.ok(hierarchy.header.pages.count >= 3);
  const { store, held, errors } = makeRecordingStore(hierarchy, 2);
  await settle(store, []);
  assert.ok(hasRoots(store));
  assert.deepEqual([...held], store.rootPages);
  const groups = coarseGroups(hierarchy, viewFrom(0), 0.1);
  const [fine, coarse] = [groups.at(-1), groups[0]];
  for (const group of [coarse, fine, coarse]) {
    await settle(store, [group]);
    assert.ok(isComplete(store, group));
    for (const cluster of entriesOf(hierarchy.members, group)) assert.ok(held.has(hierarchy.clusters.pages[cluster]));
    assert.ok(held.size <= 3, `${[...held]}`);
    assert.ok(hasRoots(store));
  }
  assert.deepEqual(errors, []);
});

test('a page that cannot be read is reported once and left out', async () => {
  const damaged = Buffer.from(NMC);
  const { header, clusters } = await open();
  const { store, held, errors } = makeRecordingStore(await open(damaged), 99);
  damaged.fill(255, header.pages.offset, header.pages.offset + 12);
  const hierarchy = await open(damaged);
  assert.throws(() => decodePage(hierarchy, 0, new Uint8Array(damaged.buffer.slice(
    damaged.byteOffset + header.pages.offset, damaged.byteOffset + header.pages.offset + header.page_size,
  ))), /damaged hierarchy of clusters: a position that is not finite/);
  store.arrived = (page) => { if (page === clusters.pages[0]) throw new Error('broken'); held.add(page); };
  const groups = coarseGroups(hierarchy, viewFrom(0), 0.1);
  await settle(store, groups);
  await settle(store, groups);
  assert.deepEqual(errors, ['broken']);
  assert.equal(held.size, header.pages.count - 1);
});

test('damage is told in one line', async () => {
  const { header } = await open();
  const changed = (at, bytes) => {
    const copy = Buffer.from(NMC);
    Buffer.from(bytes).copy(copy, at);
    return copy;
  };
  const withText = (from, to) => Buffer.from(NMC.toString('latin1').replace(from, to), 'latin1');
  const cases = [
    [Buffer.from('glTF'), /^no hierarchy of clusters: the first bytes are not "nmc"$/],
    [Buffer.alloc(0), /^no hierarchy/],
    [changed(4, [9]), /^version 9 of the format, but 1 is read here: make the file again$/],
    [changed(8, [255, 255, 255, 255, 1]), /the header is longer than the file$/],
    [changed(16, 'nonsense'), /the header is no JSON$/],
    [withText('"page_size":', '"page_sizx":'), /the header has no size of pages$/],
    [NMC.subarray(0, NMC.length - 1), /the pages end beyond the file$/],
    [withText('"bounds":[[', '"bounds":[["",'), /the header has no box of the mesh$/],
    [changed(header.clusters.offset + 16, [1, 2, 3, 4]), /a cluster of an unknown group$/],
    [changed(header.clusters.offset + 28, [1, 2, 3, 4]), /a cluster ends beyond its page$/],
    [changed(header.clusters.offset + 40, [1, 2, 3, 4]), /a cluster of too many vertices or triangles$/],
    [changed(header.groups.offset, [0, 0, 0xc0, 0x7f]), /a sphere without a finite center and radius$/],
    [changed(header.groups.offset + 16, [0, 0, 0x80, 0xbf]), /a group with a negative error$/],
  ];
  for (const [bytes, message] of cases) {
    await assert.rejects(open(bytes), (error) => message.test(error.message) && !error.message.includes('\n'), `${message}`);
  }
});

test('any changed byte gives an error or a sound hierarchy', async () => {
  const { header } = await open();
  for (let at = 0; at < header.groups.offset + 32 * header.groups.count; at += 37) {
    const damaged = Buffer.from(NMC);
    damaged[at] ^= 0xff;
    const hierarchy = await open(damaged).catch((error) => assert.doesNotMatch(error.message, /\n|undefined|null/));
    if (hierarchy) drawnClusters(hierarchy, viewFrom(0), 1, () => true);
  }
});

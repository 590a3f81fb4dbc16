// Reads `.nmc` files, which docs/clusters.md describes: header and tables at once, pages one by one. No byte is trusted.

const VERSION = 1;
const MAGIC = 'nmc\0';
const PREAMBLE = 16;
/** Words of 4 bytes per row. */
const CLUSTER_WORDS = 12;
const GROUP_WORDS = 8;
/** Most vertices and triangles of a cluster, as corners are bytes. */
const LARGEST_CLUSTER = 256;

/** Stored number of a missing group. */
export const NONE = 0xffffffff;

/**
 * Reads the header and the tables of a file, a blob. Columns have one entry per cluster or group, spheres four; `members`,
 * `results` and `contents` list the clusters that belong to a group, come from it, or are on a page.
 */
export async function readHierarchy(file) {
  const header = await readHeader(file);
  const [clusterTable, groupTable] = await Promise.all([
    readTable(file, header.clusters, CLUSTER_WORDS), readTable(file, header.groups, GROUP_WORDS),
  ]);
  const groups = groupColumns(groupTable, header.groups.count);
  const clusters = clusterColumns(clusterTable, header.clusters.count);
  const hierarchy = { file, header, clusters, groups };
  checkTables(hierarchy);
  return Object.assign(hierarchy, {
    members: listsOf(clusters.groups, groups.n),
    results: listsOf(clusters.sources, groups.n),
    contents: listsOf(clusters.pages, header.pages.count),
  });
}

/** Reads the bytes of a page. */
export function readPage({ file, header }, page) {
  return readBytes(file, header.pages.offset + page * header.page_size, header.page_size);
}

/** Returns the entries of a list, one of `listsOf`. */
export function entriesOf({ starts, items }, list) {
  return items.subarray(starts[list], starts[list + 1]);
}

async function readHeader(file) {
  const preamble = await readBytes(file, 0, Math.min(PREAMBLE, file.size));
  if (preamble.length < PREAMBLE || String.fromCharCode(...preamble.subarray(0, 4)) !== MAGIC) {
    throw new Error('no hierarchy of clusters: the first bytes are not "nmc"');
  }
  const numbers = new DataView(preamble.buffer);
  const version = numbers.getUint32(4, true);
  if (version !== VERSION) throw new Error(`version ${version} of the format, but ${VERSION} is read here: make the file again`);
  const length = Number(numbers.getBigUint64(8, true));
  check(PREAMBLE + length <= file.size, 'the header is longer than the file');
  const header = parseHeader(await readBytes(file, PREAMBLE, length));
  checkHeader(header, file.size);
  return header;
}

function parseHeader(bytes) {
  try {
    return JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
  } catch {
    throw damaged('the header is no JSON');
  }
}

function checkHeader(header, size) {
  const isCount = (n) => Number.isSafeInteger(n) && n >= 0;
  check(header !== null && isCount(header.page_size) && header.page_size > 0, 'the header has no size of pages');
  const strides = { clusters: 4 * CLUSTER_WORDS, groups: 4 * GROUP_WORDS, pages: header.page_size };
  for (const [name, stride] of Object.entries(strides)) {
    const { offset, count } = header[name] ?? {};
    check(isCount(offset) && isCount(count), `the header has no place of ${name}`);
    check(offset + count * stride <= size, `the ${name} end beyond the file`);
  }
  const areWide = Array.isArray(header.channels) && header.channels.every((channel) => isCount(channel?.width) && channel.width > 0);
  check(areWide, 'a channel of impossible width');
  const isPoint = (point) => Array.isArray(point) && point.length === 3 && point.every(Number.isFinite);
  const hasBounds = header.bounds === undefined || (Array.isArray(header.bounds) && header.bounds.length === 2 && header.bounds.every(isPoint));
  check(hasBounds, 'the header has no box of the mesh');
}

async function readTable(file, { offset, count }, words) {
  const { buffer } = await readBytes(file, offset, 4 * words * count);
  return { words: new Uint32Array(buffer), floats: new Float32Array(buffer), stride: words };
}

async function readBytes(file, begin, length) {
  const bytes = new Uint8Array(await file.slice(begin, begin + length).arrayBuffer());
  check(bytes.length === length, 'the file is shorter than its header says');
  return bytes;
}

function columnOf({ stride }, from, first) {
  return from.filter((_, i) => i % stride === first);
}

function spheresOf({ floats, stride }) {
  return floats.filter((_, i) => i % stride < 4);
}

function groupColumns(table, n) {
  return {
    n, spheres: spheresOf(table), errors: columnOf(table, table.floats, 4), levels: columnOf(table, table.words, 5),
  };
}

function clusterColumns(table, n) {
  const columns = Object.fromEntries(['sources', 'groups', 'levels', 'pages', 'offsets', 'nVertices', 'nFaces']
    .map((name, i) => [name, columnOf(table, table.words, 4 + i)]));
  return { n, spheres: spheresOf(table), ...columns };
}

function checkTables({ header, clusters, groups }) {
  check(clusters.n > 0, 'it has no clusters');
  check([groups, clusters].every(({ spheres }) => spheres.every(Number.isFinite)), 'a sphere without a finite center and radius');
  check(groups.errors.every((error) => error >= 0), 'a group with a negative error');
  for (let c = 0; c < clusters.n; c++) {
    const [source, group] = [clusters.sources[c], clusters.groups[c]];
    check([source, group].every((g) => g === NONE || g < groups.n), 'a cluster of an unknown group');
    // Levels that grow rule out cycles.
    check(source === NONE || group === NONE || groups.levels[group] > groups.levels[source], 'levels that do not grow');
    check(Math.max(clusters.nVertices[c], clusters.nFaces[c]) <= LARGEST_CLUSTER, 'a cluster of too many vertices or triangles');
    const end = clusters.offsets[c] + clusterBytes(header, clusters.nVertices[c], clusters.nFaces[c]);
    check(clusters.pages[c] < header.pages.count && end <= header.page_size, 'a cluster ends beyond its page');
    check(clusters.offsets[c] % 4 === 0, 'a cluster begins between two numbers');
  }
}

/** Returns the bytes of a cluster in its page. */
function clusterBytes({ channels, has_face_groups: hasFaceGroups }, nVertices, nFaces) {
  const width = channels.reduce((sum, channel) => sum + channel.width, 3);
  return 4 * nVertices * width + (hasFaceGroups ? 4 * nFaces : 0) + 3 * nFaces;
}

/** Sorts the numbers of rows by what a column says: those of list k are `items` from `starts[k]` to `starts[k + 1]`. */
function listsOf(column, nLists) {
  const starts = new Uint32Array(nLists + 1);
  column.forEach((list) => { if (list !== NONE) starts[list + 1]++; });
  for (let list = 0; list < nLists; list++) starts[list + 1] += starts[list];
  const [items, next] = [new Uint32Array(starts[nLists]), starts.slice()];
  column.forEach((list, row) => { if (list !== NONE) items[next[list]++] = row; });
  return { starts, items };
}

function damaged(what) {
  return new Error(`damaged hierarchy of clusters: ${what}`);
}

/** Throws an error that the file is damaged unless a condition holds. */
export function check(holds, what) {
  if (!holds) throw damaged(what);
}

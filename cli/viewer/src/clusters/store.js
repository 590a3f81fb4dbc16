// The loaded pages of a hierarchy: loads those that a cut needs, and drops the longest unused ones beyond a budget.

import { NONE, entriesOf, readPage } from './container.js';

/** Pages that are read at one time. */
const AT_ONCE = 12;

/**
 * Creates a store of at most `budget` pages. `arrived(page, bytes)`, `dropped(page)` and `failed(error)` are called when that
 * happens.
 */
export function makeStore(hierarchy, budget, { arrived, dropped, failed }) {
  const { clusters, groups, header, members } = hierarchy;
  const missing = Uint32Array.from({ length: groups.n }, (_, group) => entriesOf(members, group).length);
  // Roots are drawn when nothing else can be.
  const rootPages = clusters.pages.filter((_, cluster) => clusters.groups[cluster] === NONE);
  return {
    hierarchy, budget, arrived, dropped, failed, missing,
    rootPages: [...new Set(rootPages)],
    states: new Uint8Array(header.pages.count), used: new Float64Array(header.pages.count),
    wanted: [], turn: 0, nLoading: 0, nLoaded: 0, isClosed: false,
  };
}

const [ABSENT, LOADING, LOADED, BROKEN] = [0, 1, 2, 3];

/** Returns whether all clusters of a group are loaded. */
export function isComplete({ missing }, group) {
  return missing[group] === 0;
}

/** Returns whether the roots are loaded, without which nothing can be drawn. */
export function hasRoots({ rootPages, states }) {
  return rootPages.every((page) => states[page] === LOADED);
}

/** Asks for the clusters of groups, the first ones first; pages of earlier calls are no longer wanted. */
export function want(store, wantedGroups) {
  const { hierarchy: { clusters, members }, budget, used, rootPages } = store;
  store.turn++;
  store.wanted = [];
  const add = (page) => {
    if (used[page] === store.turn) return;
    used[page] = store.turn;
    store.wanted.push(page);
  };
  rootPages.forEach(add);
  for (const group of wantedGroups) {
    // A group is loaded whole or not at all.
    if (store.wanted.length >= budget) break;
    for (const cluster of entriesOf(members, group)) add(clusters.pages[cluster]);
  }
  dropUnused(store);
  loadNext(store);
}

/** Returns whether wanted pages are on their way. */
export function isWaiting({ wanted, states }) {
  return wanted.some((page) => states[page] <= LOADING);
}

/** Ends all loading. */
export function closeStore(store) {
  store.isClosed = true;
}

/** Drops pages, the longest unused first, until the wanted ones fit into the budget. */
function dropUnused(store) {
  const { states, used, turn, wanted, budget } = store;
  const nComing = wanted.filter((page) => states[page] <= LOADING).length;
  let tooMany = store.nLoaded + nComing - budget;
  if (tooMany <= 0) return;
  const unused = [...states.keys()].filter((page) => states[page] === LOADED && used[page] !== turn);
  unused.sort((a, b) => used[a] - used[b]);
  for (const page of unused.slice(0, tooMany)) {
    states[page] = ABSENT;
    store.nLoaded--;
    count(store, page, 1);
    store.dropped(page);
  }
}

function loadNext(store) {
  const { states, wanted } = store;
  for (const page of wanted) {
    if (store.nLoading >= AT_ONCE || store.isClosed) return;
    if (states[page] === ABSENT) load(store, page);
  }
}

async function load(store, page) {
  const { hierarchy, states } = store;
  states[page] = LOADING;
  store.nLoading++;
  try {
    const bytes = await readPage(hierarchy, page);
    if (store.isClosed) return;
    store.arrived(page, bytes);
    states[page] = LOADED;
    store.nLoaded++;
    count(store, page, -1);
  } catch (error) {
    // Coarser clusters stay in place of a broken page.
    states[page] = BROKEN;
    store.failed(error);
  } finally {
    store.nLoading--;
    loadNext(store);
  }
}

/** Counts the clusters of a page as missing in their groups, or no longer. */
function count({ hierarchy: { clusters, contents }, missing }, page, by) {
  for (const cluster of entriesOf(contents, page)) {
    const group = clusters.groups[cluster];
    if (group !== NONE) missing[group] += by;
  }
}

// A large page out of a small one: node large.js COMPARE.html FOLDER writes large-compare.html of more than 25 MB, not longer than the
// program makes it: meshes of up to a million faces.

import { readFileSync, writeFileSync } from 'node:fs';
import { deflateRawSync } from 'node:zlib';

/** Characters per script element, as in the program. */
const LETTERS = 1 << 18;
const STEPS = 65_535;

const [compare, folder] = process.argv.slice(2);
let state = 1;
const random = () => {
  state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0;
  return state / 2 ** 32;
};

writeFileSync(`${folder}/large-compare.html`, largeCompare(readFileSync(compare, 'utf8')));

function largeCompare(page) {
  const words = wordsOf(page, 'comparison');
  const [original, ...results] = [700, 500, 600, 600, 600, 600, 600, 600].map(grid);
  words.surfaces = [original, ...results].map(({ layout }) => layout);
  words.covers = words.surfaces.map(() => null);
  words.comparison.results = results.map(({ layout }) => ({ ...words.comparison.results[0], ...layout, name: 'large.ply' }));
  const islands = [island('surface-0', original.text)];
  results.forEach((result, i) => {
    islands.push(island(`surface-${i + 1}`, result.text), island(`distances-${i + 1}`, pairOf(original, result).distances));
  });
  return filled(page, 'comparison', words, islands);
}

function wordsOf(page, id) {
  return JSON.parse(page.match(new RegExp(`id="${id}">(.*?)</script>`))[1]);
}

/** Returns the page with other data. */
function filled(page, id, words, islands) {
  const bare = page.replace(/<script type="text\/plain"[^>]*>[^<]*<\/script>\n/g, '');
  const data = JSON.stringify(words).replaceAll('<', '\\u003c');
  return bare.replace(new RegExp(`(id="${id}">).*?(</script>\n)`), (_, open, close) => `${open}${data}${close}${islands.join('')}`);
}

function island(name, text) {
  const parts = text.match(new RegExp(`.{1,${LETTERS}}`, 'g')) ?? [];
  return parts.map((part) => `<script type="text/plain" data-of="${name}">${part}</script>\n`).join('');
}

/** Encodes numbers as packed.rs does: seven bits per byte, deflated, base64. */
function packed(numbers) {
  const bytes = [];
  for (let number of numbers) {
    while (number >= 128) {
      bytes.push((number % 128) | 128);
      number = Math.floor(number / 128);
    }
    bytes.push(number);
  }
  return deflateRawSync(Uint8Array.from(bytes)).toString('base64');
}

function differences(numbers) {
  let before = 0;
  return numbers.map((number) => {
    const difference = number - before;
    before = number;
    return difference < 0 ? -2 * difference - 1 : 2 * difference;
  });
}

/** Encodes a rough plate of n x n vertices in the order of their first use, as surface_data.rs does. */
function grid(n) {
  const faces = [];
  for (let i = 0; i + 1 < n; i++) {
    for (let j = 0; j + 1 < n; j++) {
      const [a, b, c, d] = [i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1];
      faces.push(a, b, c, a, c, d);
    }
  }
  const [number, order, below] = [new Map(), [], []];
  for (const vertex of faces) {
    if (!number.has(vertex)) {
      number.set(vertex, order.length);
      order.push(vertex);
      below.push(0);
    } else below.push(order.length - number.get(vertex));
  }
  const along = (share) => Math.round(share * STEPS);
  const axes = [
    order.map((vertex) => along((Math.floor(vertex / n) + 0.5 * random()) / n)),
    order.map((vertex) => along(((vertex % n) + 0.5 * random()) / n)),
    order.map((vertex) => along(0.1 + 0.05 * Math.sin(vertex / n / 20) + 0.3 * random() / n)),
  ];
  const layout = {
    vertices: order.length, faces: faces.length / 3, marked: [0, 0, 0], low: [0, 0, 0], sides: [1, 1, 0.2], step: 1 / STEPS, steps: 1,
  };
  return { layout, text: packed([...axes.flatMap(differences), ...below]) };
}

/** Encodes two surfaces with distances at the vertices of both. */
function pairOf(original, result) {
  const roots = ({ layout }) => differences(Array.from({ length: layout.vertices }, () => Math.floor(STEPS * random() ** 2)));
  return { original, result, distances: packed([...roots(result), ...roots(original)]) };
}

// Figures in words, each with a verdict.
//
// Distances are judged by what they are on a screen on which the mesh is a thousand pixels long: 0.1 % of the diagonal is one pixel. Of mean
// and largest distance, FLIP, angle and volume of 16 benchmark meshes, 72 of 77 are good at half of the vertices, 60 at a tenth, and 19 at a
// fiftieth, where 29 are poor.

import { count, number, short } from './words.js';

const PIXELS_OF_PERCENT = 10;

/** Grades of a value that is better when smaller: up to `good`, up to `fair`, above. */
function grade(value, good, fair) {
  if (value <= good) return 'good';
  return value <= fair ? 'fair' : 'poor';
}

function pixels(percent) {
  const n = percent * PIXELS_OF_PERCENT;
  if (n < 0.1) return 'under a tenth of a pixel of 1,000';
  return `${short(Number(n.toPrecision(2)))} ${n.toPrecision(2) === '1.0' ? 'pixel' : 'pixels'} of 1,000`;
}

/** Returns how many times smaller, in words such as `10×`; a dash if nothing is left. */
export function times(before, after) {
  if (!(after > 0)) return '–';
  const quotient = before / after;
  return `${quotient < 9.95 ? Number(quotient.toFixed(1)) : count(quotient)}×`;
}

/** Says how far a surface is off on average, in percent of the diagonal; `ofWhat` stands between the percent and `off`. */
export function percentOff(mean, ofWhat = '') {
  const percent = mean > 0 && mean < 1e-3 ? '< 0.001' : number(mean, mean < 0.1 ? 1 : 2);
  return `${percent} % ${ofWhat}off`;
}

/** Formats the number of bytes of a file. */
export function spokenBytes(n) {
  if (n < 1000) return `${n} bytes`;
  const [unit, name] = n < 1e6 ? [1e3, 'kB'] : [1e6, 'MB'];
  return `${Number((n / unit).toPrecision(3))} ${name}`;
}

const percentOf = (value) => `${number(value, 3)} %`;
const none = (words, others) => (value) => (value === 0 ? { grade: 'good', words } : { grade: 'poor', words: others });

/** Names, values and verdicts of the figures that a reader sees first; `best` is what is better. */
const FACTS = {
  faces: {
    title: 'Triangles', best: 'less', say: count, judge: (n, { original }) => ({ grade: 'good', words: `${times(original.faces, n)} fewer` }),
  },
  vertices: {
    title: 'Vertices', best: 'less', say: count, judge: (n, { original }) => ({ grade: 'good', words: `${times(original.vertices, n)} fewer` }),
  },
  bytes: {
    title: 'File', best: 'less', say: spokenBytes,
    judge: (n, { original }) => {
      if (!(original.bytes > 0)) return { grade: 'none', words: '' };
      return n <= original.bytes
        ? { grade: 'good', words: `${times(original.bytes, n)} smaller` } : { grade: 'poor', words: 'larger than the original' };
    },
  },
  distance_mean: {
    title: 'Mean distance', best: 'less', say: percentOf, judge: (value) => ({ grade: grade(value, 0.1, 0.3), words: pixels(value) }),
  },
  distance_max: {
    title: 'Largest distance', best: 'less', say: percentOf, judge: (value) => ({ grade: grade(value, 1, 3), words: pixels(value) }),
  },
  flip: {
    title: 'Seen difference (FLIP)', best: 'less', say: (value) => number(value, 3),
    judge: (value) => ({ grade: grade(value, 0.1, 0.2), words: { good: 'alike', fair: 'similar', poor: 'different' }[grade(value, 0.1, 0.2)] }),
  },
  normal_angle: {
    title: 'Angle of normals', best: 'less', say: (value) => `${number(value, 3)}°`,
    judge: (value) => ({ grade: grade(value, 10, 20), words: { good: 'shades alike', fair: 'shades differently', poor: 'facets show' }[grade(value, 10, 20)] }),
  },
  boundary_edges: {
    title: 'Open edges', best: 'less', say: count,
    judge: (n, { original }) => {
      if (n === 0) return { grade: 'good', words: original.boundary_edges > 0 ? 'holes are closed' : 'closed' };
      if (n > original.boundary_edges) return { grade: 'poor', words: original.boundary_edges > 0 ? 'more than in the original' : 'the original is closed' };
      return { grade: 'fair', words: 'open as the original' };
    },
  },
  non_manifold_edges: {
    title: 'Non-manifold edges', best: 'less', say: count,
    judge: (n, { original }) => {
      if (n === 0) return { grade: 'good', words: 'manifold' };
      if (n > original.non_manifold_edges) return { grade: 'poor', words: original.non_manifold_edges > 0 ? 'more than in the original' : 'the original has none' };
      return { grade: 'fair', words: 'as in the original' };
    },
  },
  self_intersecting_faces: {
    title: 'Faces that cross', best: 'less', say: count, judge: none('no face crosses another', 'faces cross each other'),
  },
  components_added: {
    title: 'Components', best: 'zero', say: (n) => (n === 0 ? 'the same' : `${n > 0 ? '+' : '−'}${count(Math.abs(n))}`),
    judge: (n) => {
      if (n === 0) return { grade: 'good', words: 'none lost' };
      return n < 0 ? { grade: 'fair', words: 'fewer than in the original' } : { grade: 'poor', words: 'more than in the original' };
    },
  },
  volume_change: {
    title: 'Volume', best: 'zero', say: (value) => `${value < 0 ? '−' : '+'}${number(Math.abs(value), 2)} %`,
    judge: (value) => ({ grade: grade(Math.abs(value), 0.5, 2), words: grade(Math.abs(value), 0.5, 2) === 'good' ? 'kept' : 'changed' }),
  },
};

/** Names of the figures that are said in words, in the order of the table. */
export const TOLD = Object.keys(FACTS);

/** Returns whether a figure is better when smaller, when larger, or near zero; null if no value is better than another. */
const BEST = { ssim: 'more', normals_ssim: 'more', psnr: 'more', silhouette_iou: 'more' };
const EVEN = new Set(['euler_characteristic', 'genus', 'components']);

/** Returns a figure in words: {title, value, grade, words}. */
export function tell(name, value, comparison) {
  const { title, say, judge } = FACTS[name];
  if (value === null || value === undefined || !Number.isFinite(value)) return { title, value: '–', grade: 'none', words: 'not measured' };
  return { title, value: say(value), ...judge(value, comparison) };
}

/** Returns the columns with the best value of a row; empty if all are equal or none is better. */
export function bestColumns(name, values) {
  const known = values.filter((value) => Number.isFinite(value));
  if (known.length < 2 || EVEN.has(name) || known.every((value) => value === known[0])) return [];
  const rank = {
    less: (value) => value, more: (value) => -value, zero: (value) => Math.abs(value),
  }[FACTS[name]?.best ?? BEST[name] ?? (/_(added|change)$/.test(name) ? 'zero' : 'less')];
  const least = Math.min(...known.map(rank));
  return values.flatMap((value, at) => (Number.isFinite(value) && rank(value) === least ? [at] : []));
}

/** Returns the headline of a result: three parts {value, words, grade}. */
export function headline({ original, result }) {
  return [size(original, result), closeness(original, result), surface(original, result)];
}

/** The file where it became nearly as much smaller as the mesh, else the triangles: textures can be most of a file. */
function size(original, result) {
  const [files, faces] = [original.bytes / result.bytes, original.faces / result.faces];
  const isFile = files >= 0.75 * faces && files > 1;
  const value = isFile ? `${times(original.bytes, result.bytes)} smaller` : `${times(original.faces, result.faces)} fewer triangles`;
  const sizes = result.bytes > 0 && original.bytes > 0 ? `, ${spokenBytes(original.bytes)} to ${spokenBytes(result.bytes)}` : '';
  return { value, words: `${count(original.faces)} to ${count(result.faces)} triangles${sizes}`, grade: faces >= 1 || isFile ? 'good' : 'poor' };
}

function closeness(original, { values }) {
  const mean = values?.distance_mean;
  if (mean === null || mean === undefined) return { value: '… off', words: values ? 'the distance is not known' : 'measuring the distance', grade: 'none' };
  const farthest = Number.isFinite(values.distance_max) ? `, ${number(values.distance_max, 2)} % at most` : '';
  return { value: percentOff(mean, 'of its size '), words: `${pixels(mean)} on average${farthest}`, grade: tell('distance_mean', mean, {}).grade };
}

function surface(original, { values }) {
  const edges = values?.boundary_edges;
  if (edges === null || edges === undefined) return { value: '…', words: values ? 'not measured' : 'looking for holes', grade: 'none' };
  if (edges === 0) {
    if (values.non_manifold_edges > 0) {
      const { grade: found } = tell('non_manifold_edges', values.non_manifold_edges, { original });
      return { value: 'closed', words: `${count(values.non_manifold_edges)} non-manifold edges`, grade: found };
    }
    if (original.boundary_edges > 0) return { value: 'closed', words: 'the original is open', grade: 'good' };
    return { value: 'closed', words: original.non_manifold_edges > 0 ? 'no holes, and now manifold' : 'no holes and manifold, as before', grade: 'good' };
  }
  const { grade: found, words } = tell('boundary_edges', edges, { original });
  return { value: found === 'fair' ? 'open as before' : 'holes', words: `${count(edges)} open edges; ${words}`, grade: found };
}

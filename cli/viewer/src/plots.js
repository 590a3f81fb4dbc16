// The three plots: a figure over size, time over input size, a figure over time. Lines join medians; a dot is a mesh.

import { makePlot, setContent } from './plot.js';
import { number, spoken } from './words.js';

const DIGITS = 3;
/** Number of medians along the axis of input sizes. */
const BINS = 8;

const labelled = ({ name, unit }) => (unit ? `${spoken(name)}, ${unit}` : spoken(name));

/** Wires up plots and legend; `pointsOf(column)` returns the values of the meshes. */
export function makePlots(data, pointsOf) {
  const { columns, methods } = data.overview;
  const column = (name) => columns.findIndex((other) => other.name === name);
  const [size, seconds] = [column('share_of_faces'), column('seconds')];
  const state = { ...data, values: [], size, seconds, hidden: new Set(), choice: null };
  state.plots = [0, 1, 2].map((i) => makePlot(document.getElementById(`plot-${i}`), (point) => wordsOf(state, point)));
  const update = () => { if (state.choice) fill(state); };
  makeLegend(state, methods, update);
  return {
    show: async (choice) => {
      const wanted = { ...choice };
      state.wanted = wanted;
      document.documentElement.dataset.plots = 'busy';
      for (const at of [size, seconds, wanted.column]) if (at >= 0) state.values[at] = await pointsOf(at);
      // A newer choice replaces this one.
      if (state.wanted !== wanted) return;
      state.choice = wanted;
      update();
      document.documentElement.dataset.plots = 'ready';
    },
    setTheme: () => { state.styles = stylesOf(state); colourLegend(state); update(); },
  };
}

/** Colours of methods, repeated after the last; black is the text colour of the page. */
function stylesOf({ colours }) {
  const ink = getComputedStyle(document.documentElement).getPropertyValue('--ink').trim();
  return colours.map((colour, i) => ({ colour: colour === '#000000' ? ink : colour, isSecond: colours.indexOf(colour) < i }));
}

function makeLegend({ hidden }, methods, update) {
  const buttons = methods.map((method, i) => {
    const button = Object.assign(document.createElement('button'), { type: 'button', className: 'chip', ariaPressed: 'true' });
    button.append(Object.assign(document.createElement('span'), { className: 'swatch' }), method);
    button.addEventListener('click', () => {
      if (!hidden.delete(i)) hidden.add(i);
      button.ariaPressed = String(!hidden.has(i));
      update();
    });
    return button;
  });
  document.getElementById('legend').replaceChildren(...buttons);
}

function colourLegend({ styles }) {
  document.querySelectorAll('#legend .swatch').forEach((swatch, i) => {
    swatch.style.background = styles[i].colour;
    swatch.classList.toggle('second', styles[i].isSecond);
  });
}

function fill(state) {
  const { overview: { columns, ratios }, plots, size, seconds, choice } = state;
  const figure = columns[choice.column];
  const share = 'faces of the result, % of the input’s';
  document.getElementById('how-plots').textContent = `Lines join the medians at the ratios, dots are the meshes at ratio ${ratios[choice.ratio]}; `
    + `point at one to see its name.${state.left_out ? ` ${number(state.left_out)} more meshes have no dot, because the plot shows a limited number.` : ''}`;
  const captions = [`${spoken(figure.name)} over size`, 'seconds over size of the input', `${spoken(figure.name)} over seconds`];
  captions.forEach((caption, i) => { document.getElementById(`caption-${i}`).textContent = caption; });
  plots[0].canvas.closest('figure').hidden = choice.column === size;
  plots[2].canvas.closest('figure').hidden = choice.column === seconds;
  const over = (column) => ({ points: dots(state, column, choice.column), lines: medians(state, column, choice.column), y: labelled(figure) });
  setContent(plots[0], { ...over(size), x: share });
  setContent(plots[1], { ...timeOverInput(state), x: 'vertices of the input', y: 'seconds' });
  setContent(plots[2], { ...over(seconds), x: 'seconds' });
}

/** Returns the methods that are shown. */
function shown({ overview: { methods }, hidden }) {
  return methods.map((_, i) => i).filter((method) => !hidden.has(method));
}

function isWhole({ x, y }) {
  return Number.isFinite(x) && Number.isFinite(y);
}

/** Returns a point for each mesh at the chosen ratio, one column over another; `x` may be a function of the mesh. */
function dots(state, x, y) {
  const { overview: { methods }, meshes, values, styles, choice } = state;
  return shown(state).flatMap((method) => meshes.map((_, mesh) => {
    const at = (choice.ratio * methods.length + method) * meshes.length + mesh;
    const along = typeof x === 'function' ? x(mesh) : values[x]?.[at];
    return { x: along, y: values[y]?.[at], method, mesh, ratio: choice.ratio, style: styles[method] };
  })).filter(isWhole);
}

/** Returns a line for each method through its medians at the ratios. */
function medians(state, x, y) {
  const { overview: { standings, ratios }, styles } = state;
  const median = (ratio, method, column) => standings[ratio][method].cells[column]?.median ?? NaN;
  return shown(state).map((method) => {
    const at = (_, ratio) => ({ x: median(ratio, method, x), y: median(ratio, method, y), method, ratio, mesh: null });
    return { style: styles[method], points: ratios.map(at).filter(isWhole) };
  }).filter((line) => line.points.length > 0);
}

/** Returns points and lines of seconds over input vertices; lines join the medians of meshes of similar sizes. */
function timeOverInput(state) {
  const points = dots(state, (mesh) => state.meshes[mesh][1], state.seconds);
  const ends = points.map(({ x }) => Math.log(x));
  const low = ends.reduce((a, b) => Math.min(a, b), Infinity);
  const width = (ends.reduce((a, b) => Math.max(a, b), -Infinity) - low) / BINS || 1;
  const lines = shown(state).map((method) => {
    const bins = Array.from({ length: BINS }, () => []);
    for (const point of points) {
      if (point.method === method) bins[Math.min(Math.floor((Math.log(point.x) - low) / width), BINS - 1)].push(point);
    }
    const middle = (bin) => ({ x: median(bin.map(({ x }) => x)), y: median(bin.map(({ y }) => y)), method, mesh: null, ratio: state.choice.ratio });
    return { style: state.styles[method], points: bins.filter((bin) => bin.length > 0).map(middle) };
  });
  return { points, lines: lines.filter((line) => line.points.length > 1) };
}

function median(values) {
  const sorted = values.sort((a, b) => a - b);
  const half = sorted.length >> 1;
  return sorted.length % 2 === 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

function wordsOf({ overview: { methods, ratios }, meshes }, { method, mesh, ratio, x, y }) {
  const who = mesh === null ? `median at ratio ${ratios[ratio]}` : `${meshes[mesh][0]} at ratio ${ratios[ratio]}`;
  return [methods[method], who, `${number(y, DIGITS)} at ${number(x, DIGITS)}`];
}

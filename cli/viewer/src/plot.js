// Draws one plot on a canvas: axes, lines, points, and the point under the mouse.

import { scaleOf, shareOf, ticksOf } from './axes.js';

/** Margins of the plot, in pixels of the page. */
const MARGIN = { left: 58, right: 14, top: 10, bottom: 44 };
/** Largest distance of the mouse from a point to select it, in pixels. */
const REACH = 14;

/** Creates the plot of a canvas; `describe(point)` returns lines of text about a point. */
export function makePlot(canvas, describe) {
  const plot = { canvas, describe, content: { points: [], lines: [], x: '', y: '' } };
  plot.ring = add(canvas.parentElement, 'ring');
  plot.tip = add(canvas.parentElement, 'tip');
  new ResizeObserver(() => askToDraw(plot)).observe(canvas.parentElement);
  canvas.addEventListener('pointermove', (event) => point(plot, event));
  canvas.addEventListener('pointerleave', () => hide(plot));
  return plot;
}

function add(parent, className) {
  const element = Object.assign(document.createElement('div'), { className, hidden: true });
  parent.append(element);
  return element;
}

/**
 * Shows `points`, each {x, y, style}, and `lines`, each {style, points}, on axes named `x` and `y`. A style is {colour, isSecond}: of two
 * of the same colour, the second has squares and dashes.
 */
export function setContent(plot, content) {
  plot.content = content;
  hide(plot);
  askToDraw(plot);
}

/** Schedules one drawing before the next frame. */
function askToDraw(plot) {
  if (plot.asked) return;
  plot.asked = true;
  requestAnimationFrame(() => draw(plot));
}

function draw(plot) {
  plot.asked = false;
  const { canvas, content: { points, lines } } = plot;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0) return;
  const ratio = globalThis.devicePixelRatio || 1;
  Object.assign(canvas, { width: width * ratio, height: height * ratio });
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  const all = [...points, ...lines.flatMap((line) => line.points)];
  const scales = { x: scaleOf(all.map(({ x }) => x)), y: scaleOf(all.map(({ y }) => y)) };
  const inner = { width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
  plot.placeOf = ({ x, y }) => [
    MARGIN.left + inner.width * shareOf(scales.x, x), MARGIN.top + inner.height * (1 - shareOf(scales.y, y)),
  ];
  drawAxes(plot, context, scales, inner);
  drawPoints(plot, context, points);
  for (const line of lines) drawLine(plot, context, line);
}

function drawAxes(plot, context, scales, inner) {
  const colours = getComputedStyle(plot.canvas);
  const [ink, soft, grid] = ['--ink', '--soft', '--line'].map((name) => colours.getPropertyValue(name));
  context.font = `12px ${colours.fontFamily}`;
  const bottom = MARGIN.top + inner.height;
  const stroke = (from, to) => { context.beginPath(); context.moveTo(...from); context.lineTo(...to); context.stroke(); };
  context.textAlign = 'center';
  Object.assign(context, { strokeStyle: grid, fillStyle: soft, lineWidth: 1, textBaseline: 'top' });
  for (const { value, words } of ticksOf(scales.x, inner.width / 55)) {
    const x = Math.round(MARGIN.left + inner.width * shareOf(scales.x, value)) + 0.5;
    stroke([x, MARGIN.top], [x, bottom]);
    context.fillText(words, x, bottom + 6);
  }
  Object.assign(context, { textAlign: 'right', textBaseline: 'middle' });
  for (const { value, words } of ticksOf(scales.y, inner.height / 34)) {
    const y = Math.round(MARGIN.top + inner.height * (1 - shareOf(scales.y, value))) + 0.5;
    stroke([MARGIN.left, y], [MARGIN.left + inner.width, y]);
    context.fillText(words, MARGIN.left - 6, y);
  }
  Object.assign(context, { fillStyle: ink, textAlign: 'center', textBaseline: 'bottom' });
  context.fillText(plot.content.x, MARGIN.left + inner.width / 2, bottom + MARGIN.bottom - 2, inner.width);
  context.save();
  context.translate(12, MARGIN.top + inner.height / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(plot.content.y, 0, 4, inner.height);
  context.restore();
}

function drawPoints({ placeOf }, context, points) {
  // Many points are drawn as small translucent squares, which stay distinguishable and are fast.
  const areMany = points.length > 2000;
  const [size, alpha] = areMany ? [1.1, 0.4] : [2.6, 0.75];
  context.globalAlpha = alpha;
  for (const point of points) {
    context.fillStyle = point.style.colour;
    const place = placeOf(point);
    if (areMany) context.fillRect(place[0] - size, place[1] - size, 2 * size, 2 * size);
    else mark(context, place, size, point.style.isSecond);
  }
  context.globalAlpha = 1;
}

function mark(context, [x, y], size, isSquare) {
  context.beginPath();
  if (isSquare) context.rect(x - size, y - size, 2 * size, 2 * size);
  else context.arc(x, y, size, 0, 2 * Math.PI);
  context.fill();
}

function drawLine({ placeOf }, context, { style, points }) {
  Object.assign(context, { strokeStyle: style.colour, fillStyle: style.colour, lineWidth: 2, lineJoin: 'round' });
  context.setLineDash(style.isSecond ? [6, 4] : []);
  context.beginPath();
  points.forEach((point, i) => context[i === 0 ? 'moveTo' : 'lineTo'](...placeOf(point)));
  context.stroke();
  context.setLineDash([]);
  for (const point of points) mark(context, placeOf(point), 3.8, style.isSecond);
}

/** Shows the text of the nearest point. */
function point(plot, { offsetX, offsetY }) {
  const { points, lines } = plot.content;
  if (!plot.placeOf) return;
  let [found, nearest] = [null, REACH];
  for (const candidate of [...lines.flatMap((line) => line.points), ...points]) {
    const [x, y] = plot.placeOf(candidate);
    const distance = Math.hypot(x - offsetX, y - offsetY);
    if (distance < nearest) [found, nearest] = [candidate, distance];
  }
  if (!found) return hide(plot);
  const [x, y] = plot.placeOf(found);
  Object.assign(plot.ring.style, { left: `${x}px`, top: `${y}px` });
  const words = plot.describe(found).map((text) => Object.assign(document.createElement('div'), { textContent: text }));
  plot.tip.replaceChildren(...words);
  plot.tip.hidden = plot.ring.hidden = false;
  const room = plot.canvas.clientWidth - plot.tip.offsetWidth - 4;
  const below = y < plot.tip.offsetHeight + 16;
  Object.assign(plot.tip.style, {
    left: `${Math.max(4, Math.min(x - plot.tip.offsetWidth / 2, room))}px`,
    top: `${below ? y + 14 : y - plot.tip.offsetHeight - 14}px`,
  });
}

function hide({ ring, tip }) {
  ring.hidden = tip.hidden = true;
}

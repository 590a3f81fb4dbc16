// Creates the example meshes, which are computed: a knot in two colours, a gear and a planet, each as a binary PLY.

/** Functions that return the file of an example, by its name. */
export const EXAMPLES = {
  Knot: () => makeRing('knot.ply', 600, 64, knotPoint),
  Gear: () => makeRing('gear.ply', 720, 64, gearPoint),
  Planet: makePlanet,
};

/** Returns a gear of fewer faces. */
export function makeSmallGear() {
  return makeRing('gear.ply', 400, 64, gearPoint);
}

/** Returns a closed ring of points: `pointOf(u, v)` gives {point, share}, a position and a share of the second colour. */
function makeRing(name, nAlong, nAround, pointOf) {
  const points = [];
  for (let i = 0; i < nAlong; i++) for (let j = 0; j < nAround; j++) points.push(pointOf(i / nAlong, j / nAround));
  const vertex = (i, j) => (i % nAlong) * nAround + (j % nAround);
  const faces = [];
  for (let i = 0; i < nAlong; i++) {
    for (let j = 0; j < nAround; j++) {
      const [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
      faces.push(a, c, b, a, d, c);
    }
  }
  return writePly(name, points, faces);
}

/** A trefoil knot with a rippled tube. */
function knotPoint(u, v) {
  const [t, around] = [2 * Math.PI * u, 2 * Math.PI * v];
  const [centre, ahead] = [knotAt(t), knotAt(t + 1e-3)];
  const along = unit(ahead.map((x, axis) => x - centre[axis]));
  const side = unit(cross(along, [0, 0, 1]));
  const up = cross(side, along);
  const wave = Math.sin(5 * around + 24 * t);
  const radius = 0.62 + 0.09 * wave;
  const [x, y] = [radius * Math.cos(around), radius * Math.sin(around)];
  return { point: centre.map((c, axis) => c + x * side[axis] + y * up[axis]), share: 0.5 + 0.5 * wave };
}

/** Returns a point on the center line of the knot. */
function knotAt(t) {
  return [Math.sin(t) + 2 * Math.sin(2 * t), Math.cos(t) - 2 * Math.cos(2 * t), -1.2 * Math.sin(3 * t)];
}

const N_TEETH = 18;
/** Corners of the gear's profile, as shares of the way from bore to rim and of the thickness. */
const PROFILE = [[0, 0], [1, 0], [1, 1], [0, 1]];

/** A gear with a bore: its profile goes along the bottom, up the rim, back along the top and down the bore. */
function gearPoint(u, v) {
  const [side, within] = [Math.floor(4 * v), (4 * v) % 1];
  const [from, to] = [PROFILE[side], PROFILE[(side + 1) % 4]];
  const [out, up] = [0, 1].map((k) => from[k] + within * (to[k] - from[k]));
  const tooth = Math.min(Math.max(0.5 + 2.2 * Math.sin(2 * Math.PI * N_TEETH * u), 0), 1);
  const radius = 0.7 + out * (1.15 + 0.25 * tooth);
  const angle = 2 * Math.PI * u;
  return { point: [radius * Math.cos(angle), radius * Math.sin(angle), 0.55 * (up - 0.5)], share: null };
}

const N_RINGS = 160;
const N_AROUND = 288;

/** A planet with ridges, coloured by height. */
function makePlanet() {
  const points = [planetPoint([0, 1, 0])];
  for (let i = 1; i < N_RINGS; i++) {
    for (let j = 0; j < N_AROUND; j++) {
      const [down, around] = [(Math.PI * i) / N_RINGS, (2 * Math.PI * j) / N_AROUND];
      points.push(planetPoint([Math.sin(down) * Math.cos(around), Math.cos(down), -Math.sin(down) * Math.sin(around)]));
    }
  }
  points.push(planetPoint([0, -1, 0]));
  const vertex = (i, j) => (i === 0 ? 0 : Math.min(1 + (i - 1) * N_AROUND + (j % N_AROUND), points.length - 1));
  const faces = [];
  for (let i = 0; i < N_RINGS; i++) {
    for (let j = 0; j < N_AROUND; j++) {
      const [a, b] = [vertex(i, j), vertex(i, j + 1)];
      const [c, d] = i + 1 === N_RINGS ? [points.length - 1, points.length - 1] : [vertex(i + 1, j), vertex(i + 1, j + 1)];
      if (a !== b) faces.push(a, c, b);
      if (c !== d) faces.push(b, c, d);
    }
  }
  return writePly('planet.ply', points, faces);
}

function planetPoint([x, y, z]) {
  let height = 0;
  for (let octave = 0; octave < 5; octave++) {
    const scale = 1.9 * 1.9 ** octave;
    const wave = Math.sin(scale * x + 1.7 * octave) + Math.sin(scale * y * 1.1 + 4 * octave + 2 * x) + Math.sin(scale * z * 0.9 - 2 * octave + 2 * y);
    height += Math.abs(wave) / 1.75 ** octave;
  }
  const radius = 1 + 0.045 * height;
  return { point: [radius * x, radius * y, radius * z], share: Math.min(Math.max((height - 1.2) / 2.6, 0), 1) };
}

/** Ends of the colour of a share: blue-green to sand. */
const COLOURS = [[38, 236], [104, 196], [112, 106]];

/** Returns a mesh as a binary PLY, with colours if its points have shares. */
function writePly(name, points, faces) {
  const isColoured = points[0].share !== null;
  const size = isColoured ? 15 : 12;
  const head = new TextEncoder().encode([
    'ply', 'format binary_little_endian 1.0', `element vertex ${points.length}`, ...['x', 'y', 'z'].map((axis) => `property float ${axis}`),
    ...(isColoured ? ['red', 'green', 'blue'].map((channel) => `property uchar ${channel}`) : []),
    `element face ${faces.length / 3}`, 'property list uchar int vertex_indices', 'end_header', '',
  ].join('\n'));
  const bytes = new Uint8Array(head.length + size * points.length + 13 * (faces.length / 3));
  bytes.set(head);
  const view = new DataView(bytes.buffer, head.length);
  points.forEach(({ point, share }, i) => {
    point.forEach((x, axis) => view.setFloat32(size * i + 4 * axis, x, true));
    if (isColoured) COLOURS.forEach(([low, high], k) => view.setUint8(size * i + 12 + k, low + share * (high - low)));
  });
  for (let i = 0, at = size * points.length; i < faces.length; i += 3, at += 13) {
    view.setUint8(at, 3);
    for (let k = 0; k < 3; k++) view.setInt32(at + 1 + 4 * k, faces[i + k], true);
  }
  return { name, bytes, beside: {} };
}

function cross([ax, ay, az], [bx, by, bz]) {
  return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
}

function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((x) => x / length);
}

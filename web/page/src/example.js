// Creates the example mesh: a trefoil knot with a rippled tube in two colours, as a binary PLY.

const N_ALONG = 600;
const N_AROUND = 64;

/** Returns the file of the example. */
export function makeExample() {
  const nVertices = N_ALONG * N_AROUND;
  const head = new TextEncoder().encode([
    'ply', 'format binary_little_endian 1.0', `element vertex ${nVertices}`,
    ...['x', 'y', 'z'].map((axis) => `property float ${axis}`), ...['red', 'green', 'blue'].map((channel) => `property uchar ${channel}`),
    `element face ${2 * nVertices}`, 'property list uchar int vertex_indices', 'end_header', '',
  ].join('\n'));
  const bytes = new Uint8Array(head.length + 15 * nVertices + 26 * nVertices);
  bytes.set(head);
  const view = new DataView(bytes.buffer, head.length);
  writeVertices(view);
  writeFaces(view, 15 * nVertices);
  return { name: 'knot.ply', bytes, beside: {} };
}

function writeVertices(view) {
  let at = 0;
  for (let i = 0; i < N_ALONG; i++) {
    const t = (2 * Math.PI * i) / N_ALONG;
    const [centre, ahead] = [knotAt(t), knotAt(t + 1e-3)];
    const along = unit(ahead.map((x, axis) => x - centre[axis]));
    const side = unit(cross(along, [0, 0, 1]));
    const up = cross(side, along);
    for (let j = 0; j < N_AROUND; j++) {
      const around = (2 * Math.PI * j) / N_AROUND;
      const wave = Math.sin(5 * around + 24 * t);
      const radius = 0.62 + 0.09 * wave;
      const [u, v] = [radius * Math.cos(around), radius * Math.sin(around)];
      for (let axis = 0; axis < 3; axis++) {
        view.setFloat32(at, centre[axis] + u * side[axis] + v * up[axis], true);
        at += 4;
      }
      const share = 0.5 + 0.5 * wave;
      for (const [low, high] of [[38, 236], [84, 196], [124, 106]]) view.setUint8(at++, low + share * (high - low));
    }
  }
}

function writeFaces(view, at) {
  const vertex = (i, j) => (i % N_ALONG) * N_AROUND + (j % N_AROUND);
  for (let i = 0; i < N_ALONG; i++) {
    for (let j = 0; j < N_AROUND; j++) {
      const [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
      for (const corners of [[a, c, b], [a, d, c]]) {
        view.setUint8(at++, 3);
        for (const corner of corners) { view.setInt32(at, corner, true); at += 4; }
      }
    }
  }
}

/** Returns a point on the center line of the knot. */
function knotAt(t) {
  return [Math.sin(t) + 2 * Math.sin(2 * t), Math.cos(t) - 2 * Math.cos(2 * t), -1.2 * Math.sin(3 * t)];
}

function cross([ax, ay, az], [bx, by, bz]) {
  return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
}

function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((x) => x / length);
}

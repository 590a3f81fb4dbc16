// Replaces the package without WebAssembly: returns rings of the requested size after a delay that the test sets.

const WRITE = ['obj', 'ply', 'stl', 'off', 'gltf', 'glb', '3mf'];
const N = 64;

/** The package's error. */
export class NeuralMeshError extends Error {}

/** Lists formats. */
export async function formats() {
  return { read: WRITE, write: WRITE, version: '0.0.0' };
}

/** Returns a ring of the size in a file of this mock, or of size N; rejects empty files and garbage. */
export async function look(bytes, { name }) {
  const head = new TextDecoder('latin1').decode(bytes.subarray(0, 40));
  if (bytes.length === 0 || head.startsWith('garbage')) throw new NeuralMeshError(`${name}: this is no mesh`);
  const n = Number(head.match(/ring (\d+)/)?.[1] ?? N);
  return { mesh: { ...ring(n), origin: [0, 0, 0], groups: [] }, notes: [] };
}

/** Returns a ring with a share of the faces. */
export async function simplify(bytes, { ratio = 0.1 }, { out, progress, signal }) {
  for (let step = 1; step <= 10; step++) {
    await new Promise((resolve) => setTimeout(resolve, globalThis.mockDelay ?? 20));
    signal?.throwIfAborted();
    progress?.(step / 10, 0);
  }
  const text = new TextEncoder().encode(`ring ${Math.max(Math.round(N * Math.sqrt(ratio)), 3)}`);
  return { bytes: text, report: {}, files: [{ name: out, bytes: text, beside: [] }], results: [], notes: [] };
}

/** Returns arbitrary figures, and distances that grow along the ring. */
export async function compare(original, result, { signal } = {}) {
  await new Promise((resolve) => setTimeout(resolve, 100));
  signal?.throwIfAborted();
  const [{ mesh: before }, { mesh: after }] = await Promise.all([original, result].map((file) => look(file.bytes, file)));
  const distances = ({ positions }) => Float32Array.from({ length: positions.length / 3 }, (_, i) => i / positions.length);
  const surfaces = [before, after].map((mesh) => ({ ...mesh, steps: 1 }));
  const figures = ['vertices', 'faces', 'distance_mean'].map((name) => ({ name, unit: '', about: `the ${name}` }));
  const values = { vertices: after.positions.length / 3, faces: after.faces.length / 3, distance_mean: 0.25 };
  const both = { of_result: distances(after), of_original: distances(before) };
  return { comparison: { figures, results: [{ name: result.name, values }] }, surfaces, distances: [both] };
}

function ring(n) {
  const positions = [];
  const faces = [];
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      const [u, v] = [i, j].map((k) => (2 * Math.PI * k) / n);
      positions.push((2 + Math.cos(v)) * Math.cos(u), (2 + Math.cos(v)) * Math.sin(u), Math.sin(v));
      const [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(([x, y]) => (x % n) * n + (y % n));
      faces.push(a, b, c, a, c, d);
    }
  }
  return { positions: Float32Array.from(positions), faces: Uint32Array.from(faces) };
}

// Small meshes for tests, and a check that a mesh is closed.

/** Returns a closed torus of `nu` x `nv` quads: positions n x 3, faces m x 3. */
export function torus(nu = 48, nv = 24) {
  const positions = new Float32Array(3 * nu * nv);
  const faces = new Uint32Array(6 * nu * nv);
  for (let u = 0; u < nu; u++) {
    for (let v = 0; v < nv; v++) {
      const [a, b] = [(2 * Math.PI * u) / nu, (2 * Math.PI * v) / nv];
      const ring = 2 + Math.cos(b);
      positions.set([ring * Math.cos(a), ring * Math.sin(a), Math.sin(b)], 3 * (u * nv + v));
      const at = (i, j) => (i % nu) * nv + (j % nv);
      faces.set([at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v), at(u + 1, v + 1), at(u, v + 1)], 6 * (u * nv + v));
    }
  }
  return { positions, faces };
}

/** Returns a torus cut along two circles with duplicate vertices, so that texture coordinates run from 0 to 1. */
export function unrolledTorus(nu = 48, nv = 24) {
  const n = (nu + 1) * (nv + 1);
  const [positions, normals, uv] = [new Float32Array(3 * n), new Float32Array(3 * n), new Float32Array(2 * n)];
  const faces = [];
  for (let u = 0; u <= nu; u++) {
    for (let v = 0; v <= nv; v++) {
      const i = u * (nv + 1) + v;
      const [a, b] = [(2 * Math.PI * (u % nu)) / nu, (2 * Math.PI * (v % nv)) / nv];
      const ring = 2 + Math.cos(b);
      positions.set([ring * Math.cos(a), ring * Math.sin(a), Math.sin(b)], 3 * i);
      normals.set([Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)], 3 * i);
      uv.set([u / nu, v / nv], 2 * i);
      if (u < nu && v < nv) faces.push(i, i + nv + 1, i + nv + 2, i, i + nv + 2, i + 1);
    }
  }
  return { positions, normals, uv, faces: Uint32Array.from(faces) };
}

/** Returns a wavy square of `n` x `n` quads with a boundary. */
export function hill(n = 32) {
  const positions = new Float32Array(3 * (n + 1) ** 2);
  const faces = [];
  for (let y = 0; y <= n; y++) {
    for (let x = 0; x <= n; x++) {
      const i = y * (n + 1) + x;
      positions.set([x / n, y / n, 0.2 * Math.sin((6 * x) / n) * Math.cos((5 * y) / n)], 3 * i);
      if (x < n && y < n) faces.push(i, i + 1, i + n + 2, i, i + n + 2, i + n + 1);
    }
  }
  return { positions, faces: Uint32Array.from(faces) };
}

/** Counts the half-edges between positions without an opposite one: 0 for a closed surface. */
export function openEdges(positions, faces) {
  const key = (i) => `${positions[3 * i]},${positions[3 * i + 1]},${positions[3 * i + 2]}`;
  const balance = new Map();
  for (let i = 0; i < faces.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1;
    const [a, b] = [key(faces[i]), key(faces[next])];
    const [edge, step] = a < b ? [`${a}|${b}`, 1] : [`${b}|${a}`, -1];
    balance.set(edge, (balance.get(edge) ?? 0) + step);
  }
  return [...balance.values()].filter((sum) => sum !== 0).length;
}

/** Returns the text of an OBJ file. */
export function toObj({ positions, uv, faces }, { head = '', material = '' } = {}) {
  const row = (array, width, i) => [...array.subarray(width * i, width * i + width)];
  const rows = (array, width, word) => Array.from({ length: array.length / width }, (_, i) => `${word} ${row(array, width, i).join(' ')}`);
  const corner = uv ? (i) => `${i + 1}/${i + 1}` : (i) => `${i + 1}`;
  const triangles = Array.from({ length: faces.length / 3 }, (_, i) => `f ${row(faces, 3, i).map(corner).join(' ')}`);
  return [head, ...rows(positions, 3, 'v'), ...(uv ? rows(uv, 2, 'vt') : []), material, ...triangles, ''].join('\n');
}

/** Encodes a text as UTF-8. */
export const utf8 = (text) => new TextEncoder().encode(text);

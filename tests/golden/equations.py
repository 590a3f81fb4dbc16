"""Equations (1) to (5) of "Neural Mesh Simplification" in plain NumPy, as they are printed or read.

Written from the paper: pair by pair, with dense matrices, in double precision, and with W x for the product of weights
with a column. `python3 equations.py` writes `equations.safetensors` beside it, which the test `equations` compares with.
Needs NumPy only.
"""

import json
import pathlib
import struct

import numpy as np

random = np.random.default_rng(20220619)


def relu(x):
    return np.maximum(x, 0.0)


def dev_conv(x, neighbours, theta, phi):
    """Eq. (1): f_i = relu(W_phi max_j W_theta (x_i - x_j))."""
    rows = []
    for i in range(len(x)):
        differences = [theta @ (x[i] - x[j]) for j in neighbours[i]]
        rows.append(relu(phi @ np.max(differences, axis=0)))
    return np.array(rows)


def attention(f, neighbours, query, key):
    """Eq. (2), read as a distribution over the neighbours of each row, by closeness; dense, zero elsewhere."""
    s = np.zeros((len(f), len(f)))
    for i in range(len(f)):
        weights = {j: np.exp(-0.5 * np.sum((query @ f[i] - key @ f[j]) ** 2)) for j in neighbours[i]}
        for j in neighbours[i]:
            s[i, j] = weights[j] / sum(weights.values())
    return s


def predicted_adjacency(s, a, neighbours):
    """Eq. (3): A_s[i, j] = S[i, :] A S[j, :]^T for i, j joined in the extended graph; dense, zero elsewhere."""
    a_s = np.zeros_like(s)
    for i in range(len(s)):
        for j in neighbours[i]:
            a_s[i, j] = s[i, :] @ a @ s[j, :].T
    return a_s


def triangle(x, i, j, k):
    """t_min, t_max and the barycenter b of a triangle, for Eq. (4)."""
    edges = np.array([x[i] - x[j], x[i] - x[k], x[j] - x[k]])
    return edges.min(axis=0), edges.max(axis=0), (x[i] + x[j] + x[k]) / 3.0


def relative_position(n, m):
    """Eq. (4): r_{n,m}."""
    return np.concatenate([n[0] - m[0], n[1] - m[1], n[2] - m[2]])


def tri_conv(triangles, f, neighbours, w1, b1, w2, b2):
    """Eq. (5), the MLP one hidden layer with ReLU, applied to every pair."""
    rows = []
    for n in range(len(f)):
        total = 0.0
        for k in neighbours[n]:
            pair = np.concatenate([relative_position(triangles[n], triangles[k]), f[n] - f[k]])
            total = total + w2 @ relu(w1 @ pair + b1) + b2
        rows.append(total)
    return np.array(rows)


def nearest(points, k):
    """Indices of the k nearest other points of each point."""
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    return np.argsort(distances, axis=1, kind="stable")[:, :k]


def icosahedron():
    """Twelve vertices, moved a little, and the thirty edges."""
    g = (1.0 + 5.0**0.5) / 2.0
    corners = [(0, s, t * g) for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(c, axis) for axis in range(3) for c in corners], dtype=float)
    lengths = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    edges = [(i, j) for i in range(12) for j in range(i + 1, 12) if lengths[i, j] < 2.01]
    moved = vertices + 0.2 * random.uniform(-1.0, 1.0, vertices.shape)
    return (moved / 4.0).astype(np.float32).astype(float), edges


def weights(*shape):
    """Weights that `f32` holds exactly."""
    return random.uniform(-0.8, 0.8, shape).astype(np.float32).astype(float)


def save(path, tensors):
    """Writes a safetensors file: numbers as F32, indices as I32."""
    header, data = {}, b""
    for name, array in tensors.items():
        array = np.asarray(array)
        kind, kept = ("I32", "<i4") if array.dtype.kind == "i" else ("F32", "<f4")
        raw = array.astype(kept).tobytes()
        header[name] = {"dtype": kind, "shape": list(array.shape), "data_offsets": [len(data), len(data) + len(raw)]}
        data += raw
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


x, edges = icosahedron()
n = len(x)
rings = [[j for j in range(n) if (min(i, j), max(i, j)) in edges] for i in range(n)]

theta_0, phi_0, theta_1, phi_1 = weights(8, 3), weights(8, 8), weights(8, 8), weights(8, 8)
f_0 = dev_conv(x, rings, theta_0, phi_0)
f_1 = dev_conv(f_0, rings, theta_1, phi_1)

# A joins only some of the samples, so that the extended graph has edges that A lacks.
a_edges = [edge for at, edge in enumerate(edges) if at % 3 != 0]
a = np.zeros((n, n))
for i, j in a_edges:
    a[i, j] = a[j, i] = 1.0
near = nearest(x, 4)
is_joined = [[i != j and (j in near[i] or i in near[j] or a[i, j] > 0) for j in range(n)] for i in range(n)]
extended = [[j for j in range(n) if is_joined[i][j]] for i in range(n)]
query, key = weights(6, 8), weights(6, 8)
s = attention(f_1, extended, query, key)
a_s = predicted_adjacency(s, a, extended)

candidates = [
    (i, j, k)
    for i in range(n)
    for j in range(i + 1, n)
    for k in range(j + 1, n)
    if a_s[i, j] > 0 and a_s[i, k] > 0 and a_s[j, k] > 0
]
prior = np.array([[(a_s[i, j] + a_s[i, k] + a_s[j, k]) / 3.0] for i, j, k in candidates])
triangles = [triangle(x, *corners) for corners in candidates]
around = nearest(np.array([t[2] for t in triangles]), 5)
w1, b1, w2, b2 = weights(7, 10), weights(7), weights(7, 7), weights(7)
w3, b3, w4, b4 = weights(7, 16), weights(7), weights(7, 7), weights(7)
g_0 = tri_conv(triangles, prior, around, w1, b1, w2, b2)
g_1 = tri_conv(triangles, g_0, around, w3, b3, w4, b4)

# The slope of a loss over the last features, through all equations, toward the positions and two tensors.
loss_weights = weights(*g_1.shape)


def loss(x, theta_0, w1):
    f = dev_conv(dev_conv(x, rings, theta_0, phi_0), rings, theta_1, phi_1)
    a_s = predicted_adjacency(attention(f, extended, query, key), a, extended)
    g = np.array([[(a_s[i, j] + a_s[i, k] + a_s[j, k]) / 3.0] for i, j, k in candidates])
    triangles = [triangle(x, *corners) for corners in candidates]
    g = tri_conv(triangles, g, around, w1, b1, w2, b2)
    return np.sum(loss_weights * tri_conv(triangles, g, around, w3, b3, w4, b4))


def slopes(of, at, step=1e-7):
    """Central differences of `of` at the array `at`, entry by entry."""
    result = np.zeros_like(at)
    for entry in np.ndindex(at.shape):
        moved = [at.copy(), at.copy()]
        moved[0][entry] += step
        moved[1][entry] -= step
        result[entry] = (of(moved[0]) - of(moved[1])) / (2.0 * step)
    return result


save(
    pathlib.Path(__file__).with_suffix(".safetensors"),
    {
        "x": x,
        "edges": edges,
        "theta_0": theta_0,
        "phi_0": phi_0,
        "theta_1": theta_1,
        "phi_1": phi_1,
        "f_0": f_0,
        "f_1": f_1,
        "a_edges": a_edges,
        "extended": [(i, j) for i in range(n) for j in extended[i]],
        "query": query,
        "key": key,
        "s": [s[i, j] for i in range(n) for j in extended[i]],
        "a_s": [a_s[i, j] for i in range(n) for j in extended[i]],
        "candidates": candidates,
        "prior": prior,
        "around": around,
        "r": [[relative_position(triangles[n], triangles[k]) for k in around[n]] for n in range(len(candidates))],
        "w1": w1,
        "b1": b1,
        "w2": w2,
        "b2": b2,
        "g_0": g_0,
        "w3": w3,
        "b3": b3,
        "w4": w4,
        "b4": b4,
        "g_1": g_1,
        "loss_weights": loss_weights,
        "slope_x": slopes(lambda x: loss(x, theta_0, w1), x),
        "slope_theta_0": slopes(lambda theta_0: loss(x, theta_0, w1), theta_0),
        "slope_w1": slopes(lambda w1: loss(x, theta_0, w1), w1),
    },
)
print(f"{len(candidates)} candidates over {n} samples")

"""The networks and losses of `src/learned_baselines/pointtrinet` in plain NumPy, one by one, in double precision.

`python3 pointtrinet.py` prints the numbers that the tests there hold. Needs NumPy only. Points and weights are sines of their
indices, so that both sides make the same ones.
"""

import numpy as np

N, N_TRIANGLES = 20, 24


def relu(x):
    return np.maximum(x, 0.0)


def sigmoid(x):
    return 1.0 / (1.0 + np.exp(-x))


vertices = np.array([[np.sin(1.3 * i), np.cos(0.7 * i), np.sin(0.4 * i * i)] for i in range(N)])
triangles = [corners for i in range(N_TRIANGLES // 2) for corners in ([i, i + 1, i + 2], [i, i + 1, i + 3])]
probabilities = np.array([0.5 + 0.4 * np.sin(1.1 * t + 0.3) for t in range(N_TRIANGLES)])
corners = np.array([vertices[triangle] for triangle in triangles])

# Widths are a sixteenth of the printed ones.
rows = {
    "classifier.points": [6, 4, 8, 64],
    "classifier.triangles": [13, 4, 8, 64],
    "classifier.decision": [128, 32, 16, 1],
    "proposals.points": [6, 4, 4, 8],
    "proposals.score": [6, 8, 4, 4, 1],
}
shapes = []
for name, widths in rows.items():
    for i, (n_in, n_out) in enumerate(zip(widths, widths[1:])):
        shapes += [(f"{name}_{i}.weights", n_in, n_out), (f"{name}_{i}.bias", 1, n_out)]
shapes.append(("proposals.pooled", 8, 8))


def tensor(number, n_rows, n_columns):
    i, j = np.meshgrid(np.arange(n_rows), np.arange(n_columns), indexing="ij")
    return 2.0 * np.sin(1.0 + 1.7 * number + 0.9 * i + 2.3 * j + 0.37 * i * j) / np.sqrt(n_rows)


tensors = {name: tensor(number, r, c) for number, (name, r, c) in enumerate(shapes)}


def mlp(name, x):
    n = len(rows[name]) - 1
    for i in range(n):
        x = x @ tensors[f"{name}_{i}.weights"] + tensors[f"{name}_{i}.bias"]
        x = relu(x) if i + 1 < n else x
    return x


def encoded(points, triangle):
    """x, y, z, u, v, w of points as a triangle, 3 x 3, sees them; its own scale is the unit."""
    center = triangle.mean(axis=0)
    scale = np.mean(np.linalg.norm(triangle - center, axis=1))
    triangle, points = (triangle - center) / scale, (points - center) / scale
    area_normal = 0.5 * np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    area = np.linalg.norm(area_normal) + 1e-6
    z = area_normal / area
    x = triangle[1] - triangle[0]
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    y = y / np.linalg.norm(y)
    result = []
    for p in points:
        foot = p - z * np.dot(z, p)
        shares = []
        for i in range(3):
            part = 0.5 * np.dot(z, np.cross(triangle[(i + 1) % 3] - foot, triangle[(i + 2) % 3] - foot))
            shares.append(np.clip((part + 1e-6 / 3) / area, -5, 5))
        result.append([np.dot(x, p), np.dot(y, p), np.dot(z, p), *shares])
    return np.array(result)


centers = corners.mean(axis=1)


def near_points(t):
    return np.argsort(np.linalg.norm(vertices - centers[t], axis=1), kind="stable")


def classified(t):
    points = mlp("classifier.points", encoded(vertices, corners[t])).max(axis=0)
    features = []
    for other in range(N_TRIANGLES):
        if other != t:
            seen = encoded(corners[other], corners[t])
            features.append([*seen.min(axis=0), *seen.max(axis=0), probabilities[other]])
    both = np.concatenate([points, mlp("classifier.triangles", np.array(features)).max(axis=0)])
    return sigmoid(mlp("classifier.decision", both[None])[0, 0])


def proposed(t):
    """Probabilities of all points, nearest first, over each edge."""
    result = []
    for edge in range(3):
        x = encoded(vertices[near_points(t)], np.roll(corners[t], -edge, axis=0))
        pooled = mlp("proposals.points", x).max(axis=0)
        first = np.concatenate([tensors["proposals.score_0.weights"], tensors["proposals.pooled"]])
        x = np.concatenate([x, np.repeat(pooled[None], len(x), axis=0)], axis=1) @ first
        x = relu(x + tensors["proposals.score_0.bias"])
        for i in range(1, 4):
            x = x @ tensors[f"proposals.score_{i}.weights"] + tensors[f"proposals.score_{i}.bias"]
            x = relu(x) if i < 3 else x
        result.append(sigmoid(x[:, 0]))
    return np.array(result)


def distance(p, triangle):
    """By many points on the triangle, halving the grid around the best."""
    best, center, size = np.inf, (1 / 3, 1 / 3), 1.0
    for _ in range(40):
        around = None
        for a in np.linspace(center[0] - size, center[0] + size, 9):
            for b in np.linspace(center[1] - size, center[1] + size, 9):
                a0, b0 = max(a, 0.0), max(b, 0.0)
                if a0 + b0 > 1:
                    a0, b0 = a0 / (a0 + b0), b0 / (a0 + b0)
                d = np.linalg.norm(p - ((1 - a0 - b0) * triangle[0] + a0 * triangle[1] + b0 * triangle[2]))
                if d < best:
                    best, around = d, (a0, b0)
        center, size = around or center, size * 0.6
    return best


def surface_to_triangles(points, length):
    total = 0.0
    for p in points:
        order = sorted((distance(p, corners[t]), probabilities[t]) for t in range(N_TRIANGLES))[:32]
        none_closer, expected = 1.0, 0.0
        for d, q in order:
            expected += none_closer * q * d
            none_closer *= 1 - q
        total += expected + none_closer * length
    return total / len(points) / length


samples = np.array([0.5 * c[0] + 0.3 * c[1] + 0.2 * c[2] for c in corners])
surface = 0.9 * vertices[:10]
normals = np.array([[np.sin(i), np.cos(2.0 * i), np.sin(3.0 * i + 1)] for i in range(10)])
normals /= np.linalg.norm(normals, axis=1)[:, None]


def triangles_to_surface(length):
    total = 0.0
    for t, p in enumerate(samples):
        near = np.argmin(np.linalg.norm(surface - p, axis=1))
        total += probabilities[t] * abs(np.dot(surface[near] - p, normals[near]))
    return total / len(samples) / length


def overlap_kernel():
    total = 0.0
    for p in samples:
        weighted = []
        for c, q in zip(corners, probabilities):
            normal = np.cross(c[1] - c[0], c[2] - c[0])
            normal /= np.linalg.norm(normal)
            inside = np.inf
            for i in range(3):
                side = np.cross(normal, c[(i + 1) % 3] - c[i])
                inside = min(inside, np.dot(side / np.linalg.norm(side), p - c[i]))
            height = abs(np.dot(normal, p - c[0]))
            weighted.append(q * max(0.0, 1 - height / (0.5 * inside + 1e-8)) if inside >= 0 else 0.0)
        total += (sum(weighted) - 1) ** 2 + (max(weighted) - 1) ** 2
    return total / len(samples)


def watertightness():
    """As the authors do it, by products of 1 - p."""
    edges = {}
    for t, (a, b, c) in enumerate(triangles):
        for edge in ((a, b), (b, c), (a, c)):
            edges.setdefault(edge, []).append(t)
    open_sides = 0.0
    for of_edge in edges.values():
        for t in of_edge:
            others = [u for u in of_edge if u != t]
            one = sum(probabilities[u] * np.prod([1 - probabilities[w] for w in others if w != u]) for u in others)
            open_sides += probabilities[t] * (1 - one)
    return open_sides / (3 * probabilities.sum() + 1e-4)


print("CLASSIFIED", [float(classified(t)) for t in (0, 7, 23)])
print("PROPOSED", proposed(5)[:, :2].tolist())
print("SURFACE_TO_TRIANGLES", surface_to_triangles(np.array([[0.3, -0.2, 0.6], [1.0, 1.0, 1.0]]), 1.5))
print("TRIANGLES_TO_SURFACE", triangles_to_surface(1.5))
print("OVERLAP_KERNEL", overlap_kernel())
print("WATERTIGHTNESS", watertightness())

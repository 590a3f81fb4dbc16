"""Flaws for sound surfaces; each function takes and returns (points, faces)."""

from math import cos, pi, sin

from shapes import joined, moved, turned
from surface import bounds, edges_of


def shaken(rng, mesh, share):
    """Moves each point by up to a share of the mean edge length."""
    points, faces = mesh
    edges = list(edges_of(faces))
    lengths = [sum((x - y) ** 2 for x, y in zip(points[a], points[b])) ** 0.5 for a, b in edges]
    reach = share * sum(lengths) / max(len(lengths), 1)
    return [tuple(x + rng.uniform(-reach, reach) for x in point) for point in points], faces


def rotated(rng, mesh):
    (a, b), points = (rng.uniform(0, 2 * pi) for _ in range(2)), mesh[0]
    points = [(x * cos(a) - y * sin(a), x * sin(a) + y * cos(a), z) for x, y, z in points]
    return [(x, y * cos(b) - z * sin(b), y * sin(b) + z * cos(b)) for x, y, z in points], mesh[1]


def stretched(rng, mesh):
    return moved(mesh, scale=[10 ** rng.uniform(-1.5, 1.5) for _ in range(3)])


def unevenly_cut(rng, mesh, n_cuts):
    """Repeatedly halves the longest edges of random faces, mostly near the last cut."""
    points, faces = list(mesh[0]), list(mesh[1])
    for _ in range(n_cuts):
        face = faces[-1 - rng.randrange(min(8, len(faces)) if rng.random() < 0.8 else len(faces))]
        length = lambda edge: sum((x - y) ** 2 for x, y in zip(points[edge[0]], points[edge[1]]))
        a, b = max(((face[i - 1], face[i]) for i in range(3)), key=length)
        middle = tuple((x + y) / 2 for x, y in zip(points[a], points[b]))
        if middle in (points[a], points[b]):
            continue
        over = [face for face in faces if a in face and b in face]
        faces = [face for face in faces if not (a in face and b in face)]
        for face in over:
            faces += [tuple(len(points) if v == gone else v for v in face) for gone in (a, b)]
        points.append(middle)
    return points, faces


def many(rng, mesh, count):
    """Returns copies of all sizes that do not touch."""
    scales = [10 ** rng.uniform(-2, 0) for _ in range(count)]
    return joined(*(moved(mesh, (4.0 * (i % 10), 4.0 * (i // 10), 0), (s, s, s)) for i, s in enumerate(scales)))


def mixed_scales(rng, mesh):
    """Returns two to five copies of very different sizes."""
    copies = [10 ** rng.uniform(-9, 3) for _ in range(rng.randint(2, 5))]
    return joined(*(moved(mesh, (8 * i * max(copies), 0, 0), (s, s, s)) for i, s in enumerate(copies)))


def far_apart(rng, mesh):
    """Returns two copies so far apart that single precision about one origin cannot represent both."""
    return joined(mesh, moved(mesh, [10 ** rng.uniform(3, 10), 0, 0]))


def nested(mesh, count, inwards):
    """Returns nested shells; with `inwards` every other one is inside out."""
    low, high = bounds(mesh[0])
    centred = moved(mesh, [-(l + h) / 2 for l, h in zip(low, high)])
    shells = [moved(centred, scale=[0.8**k] * 3) for k in range(count)]
    return joined(*(turned(shell) if inwards and k % 2 else shell for k, shell in enumerate(shells)))


def without(rng, mesh, count):
    """Removes some faces."""
    faces = list(mesh[1])
    for _ in range(min(count, len(faces) - 1)):
        faces.pop(rng.randrange(len(faces)))
    return mesh[0], faces


def repeated(rng, mesh, count):
    """Repeats some faces: unchanged, rotated, or with opposite winding."""
    ways = [lambda face: face, lambda face: face[1:] + face[:1], lambda face: face[::-1]]
    return mesh[0], mesh[1] + [rng.choice(ways)(rng.choice(mesh[1])) for _ in range(count)]


def pinched(rng, mesh, count):
    """Merges some vertices with random others."""
    points, faces = list(mesh[0]), mesh[1]
    for _ in range(count):
        points[rng.randrange(len(points))] = rng.choice(points)
    return points, faces


def turned_over(rng, mesh, share):
    return mesh[0], [face[::-1] if rng.random() < share else face for face in mesh[1]]


def rounded(mesh, steps):
    """Rounds coordinates to a coarse grid, so that many points coincide or are collinear."""
    low, high = bounds(mesh[0])
    step = max(h - l for l, h in zip(low, high)) / steps or 1.0
    return [tuple(round(x / step) * step for x in point) for point in mesh[0]], mesh[1]


def flattened(mesh, height):
    return moved(mesh, scale=(1, 1, height))


def not_finite(rng, mesh):
    points = list(mesh[0])
    for _ in range(rng.randint(1, 3)):
        point = list(rng.choice(points))
        point[rng.randrange(3)] = rng.choice([float("nan"), float("inf"), float("-inf")])
        points[rng.randrange(len(points))] = tuple(point)
    return points, mesh[1]


def littered(rng, mesh):
    """Adds unused vertices, and faces that use a vertex twice."""
    points, faces = list(mesh[0]), list(mesh[1])
    for _ in range(rng.randint(1, 5)):
        points.insert(0, tuple(rng.uniform(-1, 1) for _ in range(3)))
        faces = [tuple(v + 1 for v in face) for face in faces]
        face = rng.choice(faces)
        faces.insert(rng.randrange(len(faces)), (face[0], face[0], face[1]))
    return points, faces

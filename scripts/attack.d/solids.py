"""Generates random solids from balls, boxes, rods and rings by marching tetrahedra.

Tetrahedra need a table of only three lines, without ambiguous cases. Surfaces are closed and manifold as
long as no two crossings round to one position.
"""

from itertools import permutations, product


def ball(centre, radius):
    return lambda p: sum((x - c) ** 2 for x, c in zip(p, centre)) ** 0.5 - radius


def block(centre, halves):
    return lambda p: max(abs(x - c) - h for x, c, h in zip(p, centre, halves))


def rod(centre, axis, radius):
    u, v = (axis + 1) % 3, (axis + 2) % 3
    return lambda p: max(((p[u] - centre[u]) ** 2 + (p[v] - centre[v]) ** 2) ** 0.5 - radius, abs(p[axis]) - 0.9)


def ring(centre, axis, radius, thickness):
    u, v = (axis + 1) % 3, (axis + 2) % 3

    def field(p):
        flat = ((p[u] - centre[u]) ** 2 + (p[v] - centre[v]) ** 2) ** 0.5 - radius
        return (flat**2 + (p[axis] - centre[axis]) ** 2) ** 0.5 - thickness

    return field


def random_part(rng):
    centre, axis = [rng.uniform(-0.6, 0.6) for _ in range(3)], rng.randrange(3)
    return rng.choice([
        lambda: ball(centre, rng.uniform(0.1, 0.6)),
        lambda: block(centre, [rng.uniform(0.05, 0.6) for _ in range(3)]),
        lambda: rod(centre, axis, rng.uniform(0.05, 0.3)),
        lambda: ring(centre, axis, rng.uniform(0.2, 0.5), rng.uniform(0.05, 0.2)),
    ])()


def random_field(rng):
    """Returns unions, intersections and differences of up to eight primitives; negative inside."""
    field = random_part(rng)
    for _ in range(rng.randrange(8)):
        part, how = random_part(rng), rng.random()
        if how < 0.6:
            field = lambda p, a=field, b=part: min(a(p), b(p))
        elif how < 0.9:
            field = lambda p, a=field, b=part: max(a(p), -b(p))
        else:
            field = lambda p, a=field, b=part: min(max(a(p), b(p)), max(b(p), -a(p)))
    return field


def tetrahedra():
    """Returns the six tetrahedra of a cube along its diagonal, as offsets from its first corner."""
    for order in permutations(range(3)):
        at, corners = [0, 0, 0], [(0, 0, 0)]
        for axis in order:
            at[axis] = 1
            corners.append(tuple(at))
        yield corners


def surface(field, n, nearest):
    """Returns the zero surface over n x n x n cells of the cube from -1 to 1; crossings keep a share `nearest` from edge ends."""
    at = lambda cell: tuple(2 * x / n - 1 for x in cell)
    value = lambda cell: 1.0 if {*cell} & {0, n} else field(at(cell))
    values = {cell: value(cell) for cell in product(range(n + 1), repeat=3)}
    points, faces, number, six = [], [], {}, list(tetrahedra())

    def crossing(a, b):
        key = min(a, b), max(a, b)
        if key not in number:
            a, b = key
            share = values[a] / (values[a] - values[b])
            share = min(max(share, nearest), 1 - nearest)
            number[key] = len(points)
            points.append(tuple(x + share * (y - x) for x, y in zip(at(a), at(b))))
        return number[key]

    for cell in values:
        if n in cell:
            continue
        signs = {values[tuple(x + d for x, d in zip(cell, step))] < 0 for step in product((0, 1), repeat=3)}
        for steps in six if len(signs) == 2 else []:
            corners = [tuple(x + d for x, d in zip(cell, step)) for step in steps]
            inside = [corner for corner in corners if values[corner] < 0]
            outside = [corner for corner in corners if values[corner] >= 0]
            faces += [tuple(crossing(a, b) for a, b in face) for face in faces_between(inside, outside)]
    return points, faces


def faces_between(inside, outside):
    """Returns the faces in one tetrahedron with outward winding; corners are the crossed edges."""
    if len(inside) == 2 and len(outside) == 2:
        (a, b), (c, d) = inside, outside
        found = [((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))]
    elif inside and outside:
        found = [tuple((a, b) for a in inside for b in outside)]
    else:
        return []
    middles = [[x + y for x, y in zip(a, b)] for a, b in found[0]]
    u, v = ([q - p for p, q in zip(middles[0], corner)] for corner in middles[1:])
    away = [sum(b[k] for b in outside) * len(inside) - sum(a[k] for a in inside) * len(outside) for k in range(3)]
    looks_out = sum(away[k] * (u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2]) for k in range(3)) > 0
    return found if looks_out else [face[::-1] for face in found]

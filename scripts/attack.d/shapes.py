"""Generates surfaces; each function returns (points, faces), with outward winding if there is an outside."""

from math import cos, pi, sin


def joined(*meshes):
    """Joins several meshes into one."""
    points, faces = [], []
    for some_points, some_faces in meshes:
        faces += [tuple(v + len(points) for v in face) for face in some_faces]
        points += some_points
    return points, faces


def moved(mesh, shift=(0, 0, 0), scale=(1, 1, 1)):
    points, faces = mesh
    return [tuple(x * k + d for x, k, d in zip(point, scale, shift)) for point in points], faces


def welded(mesh):
    """Merges vertices at equal positions."""
    points, faces = mesh
    number = {}
    for point in points:
        number.setdefault(point, len(number))
    return list(number), [tuple(number[points[v]] for v in face) for face in faces]


def turned(mesh):
    """Reverses the winding of all faces."""
    return mesh[0], [face[::-1] for face in mesh[1]]


def grid(columns, rows, place, wraps=(False, False), flips=False):
    """Returns a sheet of columns x rows quads; `wraps` closes it, `flips` twists the joint of the columns."""
    nu, nv = columns + (not wraps[0]), rows + (not wraps[1])
    points = [place(i, j) for i in range(nu) for j in range(nv)]

    def at(i, j):
        if flips and i >= nu:
            j = (-j) % nv if wraps[1] else nv - 1 - j
        return i % nu * nv + j % nv

    quads = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(columns) for j in range(rows)]
    return points, [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]


def tetrahedron():
    return [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def octahedron():
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    return points, [outward(points, (x, y, z)) for x in (0, 1) for y in (2, 3) for z in (4, 5)]


def icosahedron():
    g = (1 + 5**0.5) / 2
    points = [(s, t * g, 0) for s in (-1, 1) for t in (-1, 1)]
    points = points + [(z, x, y) for x, y, z in points] + [(y, z, x) for x, y, z in points]
    near = [[sum((p - q) ** 2 for p, q in zip(a, b)) < 4.1 for b in points] for a in points]
    n = range(12)
    faces = [(a, b, c) for a in n for b in n for c in n if a < b < c and near[a][b] and near[b][c] and near[a][c]]
    return points, [outward(points, face) for face in faces]


def outward(points, face):
    """Returns the face with winding away from the origin."""
    a, b, c = (points[v] for v in face)
    volume = sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3))
    return face if volume > 0 else face[::-1]


def quartered(mesh, push=lambda point: point):
    """Cuts each face into four, and applies `push` to new points."""
    points, middles, cut = list(mesh[0]), {}, []

    def middle(a, b):
        key = min(a, b), max(a, b)
        if key not in middles:
            middles[key] = len(points)
            points.append(push(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
        return middles[key]

    for a, b, c in mesh[1]:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return points, cut


def unit(point):
    length = sum(x * x for x in point) ** 0.5
    return tuple(x / length for x in point)


def icosphere(level):
    points, faces = icosahedron()
    mesh = [unit(point) for point in points], faces
    for _ in range(level):
        mesh = quartered(mesh, unit)
    return mesh


def uv_sphere(around, rings):
    """Returns a sphere of rings."""
    points = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    for ring in range(1, rings):
        wide, high = sin(pi * ring / rings), cos(pi * ring / rings)
        turns = [2 * pi * step / around for step in range(around)]
        points += [(wide * cos(turn), wide * sin(turn), high) for turn in turns]

    def at(ring, step):
        return 2 + (ring - 1) * around + step % around

    faces = [(0, at(1, step), at(1, step + 1)) for step in range(around)]
    faces += [(1, at(rings - 1, step + 1), at(rings - 1, step)) for step in range(around)]
    for ring in range(1, rings - 1):
        for step in range(around):
            a, b, c, d = at(ring, step), at(ring + 1, step), at(ring + 1, step + 1), at(ring, step + 1)
            faces += [(a, b, c), (a, c, d)]
    return points, faces


def torus(around, through, thickness):
    def place(i, j):
        u, v = 2 * pi * i / around, 2 * pi * j / through
        return ((1 + thickness * cos(v)) * cos(u), (1 + thickness * cos(v)) * sin(u), thickness * sin(v))

    return grid(around, through, place, (True, True))


def klein(around, through):
    """Returns a Klein bottle (figure-eight immersion): closed, one-sided, self-intersecting."""
    def place(i, j):
        u, v = 2 * pi * i / around, 2 * pi * j / through
        r = 2 + cos(u / 2) * sin(v) - sin(u / 2) * sin(2 * v)
        return (r * cos(u), r * sin(u), sin(u / 2) * sin(v) + cos(u / 2) * sin(2 * v))

    return grid(around, through, place, (True, True), flips=True)


def moebius(around, across):
    """Returns a Moebius band: one side, one boundary."""
    def place(i, j):
        u, w = 2 * pi * i / around, j / across - 0.5
        return ((1 + w * cos(u / 2)) * cos(u), (1 + w * cos(u / 2)) * sin(u), w * sin(u / 2))

    return grid(around, across, place, (True, False), flips=True)


def box(nx, ny, nz):
    """Returns the unit cube with sides cut into quads."""
    counts = nx, ny, nz
    sides = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, 1):
            def place(i, j, axis=axis, u=u, v=v, end=end):
                at = [0.0] * 3
                at[axis], at[u], at[v] = float(end), i / counts[u], j / counts[v]
                return tuple(at)

            sheet = grid(counts[u], counts[v], place)
            sides.append(sheet if end else turned(sheet))
    return welded(joined(*sides))


def tube(around, rows, closed):
    """Returns a cylinder, open or with fans as caps."""
    turns = [2 * pi * i / around for i in range(around)]
    points, faces = grid(around, rows, lambda i, j: (cos(turns[i]), sin(turns[i]), j / rows), (True, False))
    if closed:
        for j in (0, rows):
            centre = len(points)
            points = points + [(0.0, 0.0, j / rows)]
            rim = [(i * (rows + 1) + j, (i + 1) % around * (rows + 1) + j) for i in range(around)]
            faces += [(b, a, centre) if j == 0 else (a, b, centre) for a, b in rim]
    return points, faces


def voxels(cells):
    """Returns the sides between filled and empty cells; each edge has two or four faces."""
    faces, corners = [], ((0, 0), (1, 0), (1, 1), (0, 1))
    number = {}
    for cell in sorted(cells):
        for axis in range(3):
            for end in (0, 1):
                beside = tuple(x + (2 * end - 1) * (k == axis) for k, x in enumerate(cell))
                if beside in cells:
                    continue
                quad = []
                for i, j in corners if end else corners[::-1]:
                    at = list(cell)
                    at[axis] += end
                    at[(axis + 1) % 3] += i
                    at[(axis + 2) % 3] += j
                    quad.append(number.setdefault(tuple(map(float, at)), len(number)))
                faces += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return list(number), faces


def leaves(n_leaves, length):
    """Returns sheets that meet in one straight chain of edges, like a book."""
    points = [(0.0, 0.0, float(k)) for k in range(length + 1)]
    faces = []
    for leaf in range(n_leaves):
        first, angle = len(points), 2 * pi * leaf / n_leaves
        points += [(cos(angle), sin(angle), float(k)) for k in range(length + 1)]
        for k in range(length):
            faces += [(k, k + 1, first + k), (k + 1, first + k + 1, first + k)]
    return points, faces

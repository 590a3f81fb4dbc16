"""Counts the topology of a mesh from its points and faces, without code of the library and without tolerances."""

from dataclasses import dataclass
from fractions import Fraction


class Sets:
    """Disjoint sets (union-find with path halving)."""

    def __init__(self):
        self.parents = {}

    def find(self, x):
        parents = self.parents
        parents.setdefault(x, x)
        while parents[x] != x:
            parents[x] = parents[parents[x]]
            x = parents[x]
        return x

    def join(self, x, y):
        self.parents[self.find(x)] = self.find(y)

    def count(self, some):
        return len({self.find(x) for x in some})


def cleaned(points, faces, weld=True):
    """The mesh as the program promises to read it: equal positions are one vertex; faces that name a vertex twice, that are not
    finite, or that have the vertices of an earlier one are gone, and so are unused vertices. Also the faces before repeated ones
    went."""
    places = {}
    finite = [all(abs(x) < float("inf") for x in point) for point in points]
    if weld:
        number = [places.setdefault(tuple(x + 0.0 for x in point), i) for i, point in enumerate(points)]
    else:
        number = list(range(len(points)))
    named = [tuple(number[v] for v in face) for face in faces if all(finite[v] for v in face)]
    named = [face for face in named if len(set(face)) == 3]
    kept = list({frozenset(face): face for face in reversed(named)}.values())[::-1]
    new = {old: i for i, old in enumerate(sorted({v for face in kept for v in face}))}
    return [points[old] for old in new], [tuple(new[v] for v in face) for face in kept], named


@dataclass
class Figures:
    """Topology of a mesh in which every vertex is used."""

    vertices: int
    faces: int
    boundary_edges: int
    odd_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    components: int
    euler: int
    """Vertices - edges + faces."""
    fans: int
    """Vertices, each counted once for every fan of faces around it."""
    loops: int
    """Boundary loops, where no edge has more than two faces."""
    disagreeing: int
    """Edges with two faces that run along it in the same direction."""

    @property
    def closed(self):
        return self.faces > 0 and self.boundary_edges == 0

    @property
    def edge_manifold(self):
        return self.non_manifold_edges == 0

    @property
    def manifold(self):
        return self.non_manifold_edges + self.non_manifold_vertices == 0

    @property
    def split_euler(self):
        """Returns the Euler characteristic after separating fans that only touch."""
        return self.euler - self.vertices + self.fans


def edges_of(faces):
    """Returns the half-edges of each edge, as (face, starting corner)."""
    edges = {}
    for number, face in enumerate(faces):
        for corner in range(3):
            a, b = face[corner], face[(corner + 1) % 3]
            edges.setdefault((a, b) if a < b else (b, a), []).append((number, corner))
    return edges


def corner_at(faces, face, vertex):
    return 3 * face + faces[face].index(vertex)


def figures(points, faces):
    """Computes the figures of a mesh from `cleaned`."""
    edges, pieces, fans, disagreeing = edges_of(faces), Sets(), Sets(), 0
    for (a, b), around in edges.items():
        first, first_corner = around[0]
        for face, corner in around[1:]:
            pieces.join(first, face)
            for vertex in (a, b):
                fans.join(corner_at(faces, first, vertex), corner_at(faces, face, vertex))
        if len(around) == 2:
            face, corner = around[1]
            disagreeing += faces[first][first_corner] == faces[face][corner]
    at_vertex = {}
    for face, corners in enumerate(faces):
        for corner, vertex in enumerate(corners):
            at_vertex.setdefault(vertex, set()).add(fans.find(3 * face + corner))
    counts = [len(around) for around in edges.values()]
    return Figures(
        vertices=len(points),
        faces=len(faces),
        boundary_edges=counts.count(1),
        odd_edges=sum(count % 2 for count in counts),
        non_manifold_edges=sum(count > 2 for count in counts),
        non_manifold_vertices=sum(len(found) > 1 for found in at_vertex.values()),
        components=pieces.count(range(len(faces))),
        euler=len(points) - len(edges) + len(faces),
        fans=sum(map(len, at_vertex.values())),
        loops=loops(faces, edges, fans),
        disagreeing=disagreeing,
    )


def loops(faces, edges, fans):
    """Counts boundary loops; a boundary continues within a fan, not across a vertex where fans only touch."""
    rim = Sets()
    boundary = [(edge, around[0][0]) for edge, around in edges.items() if len(around) == 1]
    for edge, face in boundary:
        for vertex in edge:
            rim.join(edge, ("fan", fans.find(corner_at(faces, face, vertex))))
    return rim.count(edge for edge, _ in boundary)


def orientable(faces):
    """Returns whether turning faces can make the winding consistent across all edges with two faces."""
    sides = Sets()
    for around in edges_of(faces).values():
        if len(around) == 2:
            (f, i), (g, j) = around
            agree = faces[f][i] != faces[g][j]
            sides.join((f, 0), (g, 0 if agree else 1))
            sides.join((f, 1), (g, 1 if agree else 0))
    return all(sides.find((face, 0)) != sides.find((face, 1)) for face in range(len(faces)))


def odd_edges(faces):
    """Returns the edges with an odd number of faces, including repeated faces."""
    return sum(len(around) % 2 for around in edges_of(faces).values())


def has_no_area(a, b, c):
    """Returns whether three points are collinear, decided exactly."""
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    reach = max(map(abs, (*a, *b, *c)))
    size = max(map(abs, u)) * max(map(abs, v))
    # Rounding of the differences, then of the products.
    if max(map(abs, cross)) > 8e-16 * (size + reach * (max(map(abs, u)) + max(map(abs, v)))) > 1e-290:
        return False
    a, b, c = ([Fraction(x) for x in point] for point in (a, b, c))
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    return u[1] * v[2] == u[2] * v[1] and u[2] * v[0] == u[0] * v[2] and u[0] * v[1] == u[1] * v[0]


def degenerate(points, faces):
    """Returns the faces without area, including those with two corners at one position."""
    return sum(has_no_area(*(points[v] for v in face)) for face in faces)


def bounds(points):
    return [min(axis) for axis in zip(*points)], [max(axis) for axis in zip(*points)]


def diagonal(points):
    low, high = bounds(points)
    return sum((h - l) ** 2 for l, h in zip(low, high)) ** 0.5

"""Draws from a seed: a mesh, its file format, and runs of the program on it."""

from dataclasses import dataclass, field
from math import cos, pi, sin
from random import Random

import flaws
import shapes
import solids
from formats import single

ENDINGS = [".ply", ".obj", ".off", ".stl", ".glb"]
RATIOS = ["0.5", "0.2", "0.1", "0.05", "0.02"]


@dataclass
class Drawn:
    """A mesh before it is written to a file."""

    points: list
    faces: list
    recipe: list = field(default_factory=list)
    """Names of the shape and its alterations."""
    plain: bool = True
    """Whether single precision about one origin can represent it, so that the program must not reject it."""
    double: bool = False

    def then(self, name, mesh, plain=True):
        self.points, self.faces = mesh
        self.recipe.append(name)
        self.plain = self.plain and plain


def base(rng):
    """Draws an initial surface: its name and mesh."""
    n = lambda low, high: rng.randint(low, high)
    closed = {
        "icosphere": lambda: shapes.icosphere(n(0, 3)),
        "ball": lambda: shapes.uv_sphere(4 * n(1, 8), 2 * n(1, 8)),
        "ring": lambda: shapes.torus(4 * n(1, 8), 4 * n(1, 5), rng.uniform(0.05, 0.9)),
        "box": lambda: shapes.box(n(1, 8), n(1, 8), n(1, 8)),
        "rod": lambda: shapes.tube(4 * n(1, 8), n(1, 8), True),
        "octahedron": shapes.octahedron,
    }
    large = lambda: shapes.torus(4 * n(35, 60), 4 * n(15, 30), 0.4)
    others = {
        "tetrahedron": shapes.tetrahedron,
        "klein": lambda: shapes.klein(n(3, 24), n(3, 24)),
        "moebius": lambda: shapes.moebius(n(3, 40), n(1, 8)),
        "tube": lambda: shapes.tube(n(3, 30), n(1, 12), False),
        "terrain": lambda: terrain(rng, n(2, 25), n(2, 25)),
        "leaves": lambda: shapes.leaves(n(3, 8), n(1, 12)),
        "soup": lambda: soup(rng, n(3, 40), n(1, 150)),
        "fan": lambda: shapes.grid(1, n(3, 60), lambda i, j: (cos(j / 9) * i, sin(j / 9) * i, 0.0)),
    }
    kind = rng.random()
    if kind < 0.01:
        return "large ring", large()
    if kind < 0.34:
        name = rng.choice(list(closed))
        return name, closed[name]()
    if kind < 0.58:
        return "solid", solids.surface(solids.random_field(rng), n(4, 14), rng.choice([0.0, 1e-6, 0.05, 0.3]))
    if kind < 0.72:
        return "voxels", voxels(rng)
    if kind < 0.82:
        return "touching", touching(rng, closed)
    name = rng.choice(list(others))
    return name, others[name]()


def terrain(rng, columns, rows):
    heights = {}
    return shapes.grid(columns, rows, lambda i, j: (float(i), float(j), heights.setdefault((i, j), rng.gauss(0, 0.4))))


def soup(rng, n_points, n_faces):
    points = [tuple(rng.uniform(-1, 1) for _ in range(3)) for _ in range(n_points)]
    return points, [tuple(rng.sample(range(n_points), 3)) for _ in range(n_faces)]


def voxels(rng):
    """Draws random cells of random density, sometimes grown cell by cell across faces, edges or corners."""
    side, share = rng.randint(2, 6), rng.uniform(0.15, 0.8)
    cells = {(i, j, k) for i in range(side) for j in range(side) for k in range(side) if rng.random() < share} or {(0, 0, 0)}
    if rng.random() < 0.4:
        cells, at = {(0, 0, 0)}, (0, 0, 0)
        for _ in range(rng.randint(1, 20)):
            at = tuple(x + rng.choice((-1, 0, 1)) for x in at)
            cells.add(at)
    return shapes.voxels(cells)


def touching(rng, closed):
    """Draws solids that share vertices: boxes around an edge, chains of boxes along edges or corners, or balls joined at poles."""
    n = rng.randint(1, 5)
    box, count = shapes.box(n, n, n), rng.randint(2, 6)
    how = rng.randrange(4)
    if how == 0:
        steps = [(i, i, 0) for i in range(count)]
    elif how == 1:
        steps = [(i, i, i) for i in range(count)]
    elif how == 2:
        steps = [(i, i % 2, (i + 1) % 2) for i in range(count)]
    else:
        box, steps = shapes.uv_sphere(4 * rng.randint(1, 5), 2 * rng.randint(1, 5)), [(0, 0, 2 * i) for i in range(count)]
    return shapes.welded(shapes.joined(*(shapes.moved(box, step) for step in steps)))


def alterations(rng, mesh):
    """Returns alterations by name: the altered mesh, and whether it is still plain."""
    n = lambda low, high: rng.randint(low, high)
    small = len(mesh[1]) < 400
    some = {
        "shaken": lambda: (flaws.shaken(rng, mesh, rng.choice([0.01, 0.1, 0.3])), True),
        "rotated": lambda: (flaws.rotated(rng, mesh), True),
        "stretched": lambda: (flaws.stretched(rng, mesh), True),
        "cut": lambda: (flaws.unevenly_cut(rng, mesh, n(1, 150)), True),
        "sheet": lambda: (flaws.flattened(mesh, 10 ** rng.uniform(-7, -1)), False),
        "flat": lambda: (flaws.flattened(mesh, 0.0), False),
        "nested": lambda: (flaws.nested(mesh, n(2, 4), rng.random() < 0.5), True),
        "without": lambda: (flaws.without(rng, mesh, n(1, 4)), True),
        "repeated": lambda: (flaws.repeated(rng, mesh, n(1, 4)), True),
        "pinched": lambda: (flaws.pinched(rng, mesh, n(1, 3)), True),
        "turned over": lambda: (flaws.turned_over(rng, mesh, rng.choice([0.02, 0.5])), True),
        "rounded": lambda: (flaws.rounded(mesh, rng.choice([8, 50, 1000])), True),
        "littered": lambda: (flaws.littered(rng, mesh), True),
        "mixed scales": lambda: (flaws.mixed_scales(rng, mesh), False),
        "far apart": lambda: (flaws.far_apart(rng, mesh), False),
    }
    if small:
        some["many"] = lambda: (flaws.many(rng, mesh, n(2, 12 if len(mesh[1]) > 60 else 60)), True)
    return some


def placed(rng, drawn):
    """Sometimes scales a mesh to be very large or small, or moves it far from the origin."""
    mesh = drawn.points, drawn.faces
    kind = rng.random()
    if kind < 0.06:
        drawn.then("scaled", shapes.moved(mesh, scale=[10 ** rng.uniform(-30, 30)] * 3), plain=False)
    elif kind < 0.1:
        drawn.then("denormal", shapes.moved(mesh, scale=[10 ** rng.uniform(-46, -36)] * 3), plain=False)
    elif kind < 0.2:
        shift = [rng.choice([0, 1, -1]) * 10 ** rng.uniform(1, 9) for _ in range(3)]
        drawn.then("offset", shapes.moved(mesh, shift), plain=False)


def drawn(seed):
    """Draws the mesh of a seed."""
    rng = Random(f"mesh {seed}")
    name, mesh = base(rng)
    while not mesh[1]:
        name, mesh = base(rng)
    result = Drawn(*mesh, [name])
    for _ in range(rng.choice([0, 0, 1, 1, 2])):
        some = alterations(rng, (result.points, result.faces))
        name = rng.choice(list(some))
        result.then(name, *some[name]())
    placed(rng, result)
    result.double = rng.random() < 0.2
    if rng.random() < 0.03:
        result.then("not finite", flaws.not_finite(rng, (result.points, result.faces)), plain=False)
    if result.plain and not result.double:
        result.points = [tuple(map(single, point)) for point in result.points]
    return result


def runs(seed, drawn, ending):
    """Draws four runs on the mesh of a seed, the last with another kind of target: extension of the output, options."""
    rng, inside = Random(f"runs {seed}"), Random(f"inside {seed}")
    for number in range(4):
        target = other_target(rng, len(drawn.faces)) if number == 3 else ["--ratio", rng.choice(RATIOS)]
        out = rng.choice([ending, *ENDINGS])
        some = options(rng)
        if inside.random() < 0.15:
            some = what_is_inside(inside) + some
        if out in (".ply", ".stl") and rng.random() < 0.15:
            some = ["--format", out[1:] + "-ascii", *some]
        yield out, target + some


def other_target(rng, n_faces):
    return rng.choice([
        lambda: ["--ratio", "1"],
        lambda: ["--faces", str(rng.randint(1, n_faces + 5))],
        lambda: ["--vertices", str(rng.randint(1, n_faces // 2 + 5))],
        lambda: ["--error", f"{10 ** rng.uniform(-2, 1.3):.3g}%"],
        lambda: ["--error", f"{10 ** rng.uniform(-2, 1.3):.3g}%"],
        lambda: ["--size", str(int(rng.uniform(0.02, 1.1) * 40 * n_faces) + 100)],
        lambda: ["--lods", rng.choice(["0.5,0.1", "0.7,0.3,0.05", "1,0.02"])],
    ])()


def what_is_inside(rng):
    """Draws options that remove hidden components, holes and fins."""
    return rng.choice([
        ["--printable"], ["--printable"], ["--fill-holes"], ["--fill-holes=6"], ["--hidden", "drop"],
    ])


def options(rng):
    """Draws options besides the target; about a third of the runs have only the number of threads."""
    some = []
    if rng.random() < 0.45:
        some += rng.choice([
            ["--subset"], ["--subset"], ["--lock-boundaries"], ["--subset", "--lock-boundaries"],
            ["--prune"], ["--prune=3%"], ["--keep-components"], ["--weld", "0.1%"],
        ])
    if rng.random() < 0.3:
        some += rng.choice([
            ["--optimize", "mean"], ["--optimize", "max"], ["--optimize", "normals"], ["--scores", "geometry"],
            ["--effort", "fast"], ["--effort", "best"],
        ])
    if rng.random() < 0.12:
        some += rng.choice([["--keep-features"], ["--crease-angle", "10"]])
    if rng.random() < 0.1:
        some += ["--seed", str(rng.randint(0, 99))]
    return some + ["--threads", rng.choice(["1", "1", "2", "3", "8"])]

"""Inputs and outputs to judge: the mesh of a run, and the meshes that it wrote."""

from functools import cached_property

import formats
import surface

# Limits of the boundary edges opened by removing repeated faces, and of their share of the faces, up to which holes must be closed.
SMALL_HOLES, FEW = 6, 0.05


class Subject:
    """The input as the judge reads its file."""

    def __init__(self, path, plain=True):
        self.path, self.plain = path, plain
        self.points, self.faces, self.named = surface.cleaned(*formats.read(path))

    @cached_property
    def figures(self):
        return surface.figures(self.points, self.faces)

    @cached_property
    def degenerate(self):
        return surface.degenerate(self.points, self.faces)

    @cached_property
    def two_sided(self):
        return surface.orientable(self.faces)

    @cached_property
    def diagonal(self):
        return surface.diagonal(self.points)

    @cached_property
    def is_single(self):
        return all(formats.single(x) == x for point in self.points for x in point)

    def is_understood(self, done):
        """Returns whether the program read an equal mesh; it may weld positions that are equal in single precision."""
        said = done.report["input"]
        return "--weld" not in done.options and all(said[key] == getattr(self.figures, key) for key in said)

    @cached_property
    def boundary(self):
        """Returns the boundary edges as pairs of points."""
        edges = surface.edges_of(self.faces)
        return {frozenset(self.points[v] for v in edge) for edge, around in edges.items() if len(around) == 1}

    @cached_property
    def opened_by_cleaning(self):
        """Returns whether it is closed, apart from small holes from removed repeated faces."""
        # A mesh of one repeated face has no inside.
        are_few = len(self.faces) > 1 and 0 < len(self.named) - len(self.faces) <= max(FEW * len(self.faces), 1)
        return are_few and self.figures.boundary_edges <= SMALL_HOLES and surface.odd_edges(self.named) == 0


class Result:
    """A written mesh file with its part of the report."""

    def __init__(self, path, said, outcome, target, weld):
        self.path, self.said, self.outcome, self.target, self.weld = path, said, outcome, target, weld
        self.all_points, self.all_faces = formats.read(path)
        self.points, self.faces, self.named = surface.cleaned(self.all_points, self.all_faces, weld)
        self.figures = surface.figures(self.points, self.faces)

"""What a simplification gives: a lighter mesh and its story."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._native import NeuralMeshError
from ._report import Report

M = TypeVar("M")


@dataclass(frozen=True)
class Map:
    """Where a result comes from, for data that the caller carries over."""

    output_vertices: NDArray[np.int32]
    """Result vertex of each input vertex; -1 for an input vertex without one."""
    input_vertices: NDArray[np.int32]
    """Closest input vertex that was merged into each result vertex; -1 for a result vertex without one."""
    corner_faces: NDArray[np.int32]
    """Cleaned input face that each corner of the result's faces is on, n_faces x 3."""
    corner_weights: NDArray[np.float32]
    """Barycentric weights of each corner on its input face, n_faces x 3 x 3; the three are at least 0 and sum to 1."""


class NeuralMeshWarning(UserWarning):
    """A result that is not as one might think: larger than asked, of an input that had to be cleaned, or without some of its components."""


@dataclass(frozen=True)
class Light(Generic[M]):
    """A lighter mesh. `v, f = light` unpacks it; `light.mesh` is of the type that was given."""

    vertices: Any
    """Positions, n x 3, of the kind of array that was given, else numpy's; `float64` where such were given, else `float32`."""
    faces: Any
    """Vertices of the triangles, n_faces x 3, `int32`."""
    attributes: Mapping[str, NDArray[Any]]
    """Values by name; the row `wedges[f, i]` belongs to corner `i` of face `f`. Without seams there is a row for each vertex. Names are
    those given; what a file carries is called `uv`, `normals`, `colors` and `tangents`, whatever the file calls it."""
    wedges: NDArray[np.int32] | None
    """Row of `attributes` of each corner, n_faces x 3; `None` without attributes."""
    groups: NDArray[Any] | None
    """Group of each face, n_faces, as in the input; `None` without groups."""
    group_names: Mapping[int, str]
    """Names of materials, groups and objects of a file, by group."""
    face_attributes: Mapping[str, NDArray[Any]]
    """Values of faces by name, n_faces or n_faces x k; each face takes those of the input face below it."""
    report: Report
    """The report, as `neural-mesh simplify --report` writes it; `report_schema()` describes it."""
    map: Map | None
    """The map from input to result, with `map=True`."""
    sources: NDArray[np.int32] | None
    """Input vertex of each result vertex, if every vertex is one (`subset=True`, the paper's assembly, or no change)."""
    paths: tuple[str, ...]
    """Paths of the written files."""
    mesh: M = field(repr=False)
    """The result in the type of mesh that was given: trimesh, Open3D, pyvista, or the pair of arrays."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.vertices, self.faces))

    def __repr__(self) -> str:
        return f"Light({len(self.vertices)} vertices, {len(self.faces)} faces, {self.outcome})"

    @property
    def outcome(self) -> str:
        """`reached`, or `stopped: ` and why the result is larger than asked."""
        return self.report["outcome"]

    @property
    def reached(self) -> bool:
        """Whether the result is as small, or as near, as asked."""
        return self.outcome == "reached"

    @property
    def cleaned(self) -> Mapping[str, int]:
        """What was cleaned on reading, as far as there was something: `{"non_finite_faces": 3}`."""
        counts: Mapping[str, int] = self.report["cleaned"]  # type: ignore[assignment]
        return {what: n for what, n in counts.items() if n > 0}

    def save(self, path: str | os.PathLike[str], *, format: str | None = None, force: bool = False) -> str:
        """Writes the mesh with its attributes and groups to a file of the format that its name says, or of `format`; gives its name.
        A file that is there is replaced with `force` alone. Names of groups, materials and textures of a file are in what `out` writes."""
        from ._simplify import written

        written(self, {"out": path, "format": format, "force": force})
        return os.fspath(path)

    def to_bytes(self, format: str) -> bytes:
        """The bytes of the file that `save` writes: `ply`, `obj`, `glb`, `stl`, `off`, `3mf`."""
        from ._simplify import written

        return written(self, {"format": format, "bytes": True}) or b""

    def corners(self, name: str) -> NDArray[Any]:
        """The values of an attribute at the corners of the faces, n_faces x 3 x width."""
        if self.wedges is None:
            raise NeuralMeshError(f"{name}: the mesh has no such attribute")
        corners: NDArray[Any] = self.attributes[name][self.wedges]
        return corners

    def split(self) -> tuple[NDArray[Any], NDArray[np.int32], dict[str, NDArray[Any]]]:
        """Vertices, faces and attributes by vertex, as engines want them: a vertex for each set of values, so that vertices at seams
        come more than once."""
        return split(np.asarray(self.vertices), np.asarray(self.faces), self.wedges, self.attributes)


def split(
    vertices: NDArray[Any], faces: NDArray[np.int32], wedges: NDArray[np.int32] | None, attributes: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[Any], NDArray[np.int32], dict[str, NDArray[Any]]]:
    """A mesh with a vertex for each pair of vertex and wedge that a corner has."""
    if wedges is None or len(faces) == 0:
        return vertices, faces, {}
    keys = faces.astype(np.int64) * (int(wedges.max()) + 1) + wedges
    _, first, of_corner = np.unique(keys, return_index=True, return_inverse=True)
    vertex, wedge = faces.reshape(-1)[first], wedges.reshape(-1)[first]
    corners = of_corner.reshape(-1, 3).astype(np.int32)
    return vertices[vertex], corners, {name: values[wedge] for name, values in attributes.items()}


class NotReachedError(NeuralMeshError):
    """The result is not as asked: the bound of `error` or `size` is not held, or with `strict=True` the size is not reached.
    `results` has it all the same."""

    def __init__(self, why: str, results: tuple[Light[Any], ...]) -> None:
        super().__init__(why)
        self.results = results

    def __reduce__(self) -> Any:
        return NotReachedError, (str(self), self.results)

    @property
    def result(self) -> Light[Any]:
        """The result, or the first of the levels of detail."""
        return self.results[0]

"""The result of a simplification: a lighter mesh with its report and map."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeAlias, TypeVar, Union, overload

import numpy as np
from numpy.typing import NDArray

from ._native import NeuralMeshError
from ._report import Report


class ArrayLike(Protocol):
    """Rows of numbers: an array of numpy, torch or jax."""

    def __array__(self) -> Any: ...


class VerticesLike(Protocol):
    """A mesh of trimesh or Open3D, a result of this package, or any object with `vertices`."""

    @property
    def vertices(self) -> Any: ...


class PointsLike(Protocol):
    """A mesh of pyvista or meshio."""

    @property
    def points(self) -> Any: ...


class OpenFile(Protocol):
    """A file that is open for reading."""

    def read(self) -> bytes | str: ...


Arrays: TypeAlias = tuple[NDArray[Any], NDArray[np.int32]]
Rows: TypeAlias = Union[ArrayLike, Sequence[Sequence[float]]]
# What has no type of its own to return to.
Plain: TypeAlias = Union[str, "os.PathLike[str]", bytes, bytearray, memoryview, OpenFile, Rows, tuple[Rows, Rows], "Light[Any]"]
Mesh: TypeAlias = Union[Plain, VerticesLike, PointsLike]

M = TypeVar("M")
M_co = TypeVar("M_co", covariant=True)


@dataclass(frozen=True)
class Map:
    """The correspondence between input and result, for carrying the caller's own data."""

    output_vertices: NDArray[np.int32]
    """Result vertex of each input vertex; -1 for an input vertex without one."""
    input_vertices: NDArray[np.int32]
    """Closest input vertex that was merged into each result vertex; -1 for a result vertex without one."""
    corner_faces: NDArray[np.int32]
    """Cleaned input face that each corner of the result's faces is on, n_faces x 3."""
    corner_weights: NDArray[np.float32]
    """Barycentric weights of each corner on its input face, n_faces x 3 x 3; the three are at least 0 and sum to 1."""


class NeuralMeshWarning(UserWarning):
    """Warning of a result larger than requested, of a cleaned input, or of dropped components."""


class OwnMesh:
    """The attribute `Light.mesh`."""

    @overload
    def __get__(self, light: None, kind: Any = None) -> OwnMesh: ...
    @overload
    def __get__(self, light: Light[Plain], kind: Any = None) -> Arrays: ...
    @overload
    def __get__(self, light: Light[M], kind: Any = None) -> M: ...
    def __get__(self, light: Light[Any] | None, kind: Any = None) -> Any:
        return self if light is None else light._mesh


@dataclass(frozen=True)
class Light(Generic[M_co]):
    """A simplified mesh; `v, f = light` unpacks it, and `light.mesh` has the type of the input."""

    vertices: Any
    """Positions, n x 3, in the array type of the input, numpy for files; `float64` for `float64` input, else `float32`."""
    faces: Any
    """Vertices of the triangles, n_faces x 3, `int32`."""
    attributes: Mapping[str, NDArray[Any]]
    """Values by name; row `wedges[f, i]` belongs to corner `i` of face `f`. Without seams there is one row per vertex. Attributes of a
    file are named `uv`, `normals`, `colors` and `tangents`; others keep their names."""
    wedges: NDArray[np.int32] | None
    """Row of `attributes` of each corner, n_faces x 3; `None` without attributes."""
    groups: NDArray[Any] | None
    """Group of each face, n_faces, as in the input; `None` without groups."""
    group_names: Mapping[int, str]
    """Names of materials, groups and objects of a file, by group."""
    face_attributes: Mapping[str, NDArray[Any]]
    """Face values by name, n_faces or n_faces x k; each face takes those of the closest input face."""
    report: Report
    """The report, as `neural-mesh simplify --report` writes it; `report_schema()` describes it."""
    map: Map | None
    """Correspondence between input and result; `None` without `map=True`."""
    sources: NDArray[np.int32] | None
    """Input vertex of each result vertex, n; `None` if vertices may have moved (see `subset`)."""
    paths: tuple[str, ...]
    """Paths of the written files."""
    _mesh: Any = field(repr=False)

    mesh = OwnMesh()
    """The result in the type of the input: trimesh, Open3D, pyvista, meshio, PyMeshLab, or a pair of arrays."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.vertices, self.faces))

    def __repr__(self) -> str:
        return f"Light({len(self.vertices)} vertices, {len(self.faces)} faces, {self.outcome})"

    @property
    def outcome(self) -> str:
        """Outcome: `reached`, or `stopped: ` and the reason why the result is larger than requested."""
        return self.report["outcome"]

    @property
    def reached(self) -> bool:
        """Whether the result meets the requested size or distance."""
        return self.outcome == "reached"

    @property
    def cleaned(self) -> Mapping[str, int]:
        """Nonzero counts of what cleaning removed or merged on reading, such as `{"non_finite_faces": 3}`."""
        counts: Mapping[str, int] = self.report["cleaned"]  # type: ignore[assignment]
        return {name: n for name, n in counts.items() if n > 0}

    def save(self, path: str | os.PathLike[str], *, format: str | None = None, force: bool = False) -> str:
        """Writes the mesh with its attributes and groups to a file and returns its path.

        The format is `format`, or else follows from the extension. `force` replaces an existing file, which is an error otherwise. Group
        names, materials and textures of an input file are not written: use the option `out` of `simplify` for them."""
        from ._simplify import write_light

        write_light(self, {"out": path, "format": format, "force": force})
        return os.fspath(path)

    def to_bytes(self, format: str) -> bytes:
        """Returns the mesh as bytes of a file in `ply`, `obj`, `glb`, `stl`, `off` or `3mf` format."""
        from ._simplify import write_light

        return write_light(self, {"format": format, "bytes": True}) or b""

    def corners(self, name: str) -> NDArray[Any]:
        """Returns the values of an attribute at the corners of the faces, n_faces x 3 x width.

        Raises `NeuralMeshError` if the mesh has no attributes."""
        if self.wedges is None:
            raise NeuralMeshError(f"{name}: the mesh has no such attribute")
        corners: NDArray[Any] = self.attributes[name][self.wedges]
        return corners

    def split(self) -> tuple[NDArray[Any], NDArray[np.int32], dict[str, NDArray[Any]]]:
        """Returns vertices (n x 3), faces (m x 3) and attributes per vertex, as rendering engines need; vertices at seams are duplicated."""
        return split(np.asarray(self.vertices), np.asarray(self.faces), self.wedges, self.attributes)


def split(
    vertices: NDArray[Any], faces: NDArray[np.int32], wedges: NDArray[np.int32] | None, attributes: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[Any], NDArray[np.int32], dict[str, NDArray[Any]]]:
    """Splits vertices so that each has one row of attributes: one vertex per pair of vertex and wedge in use."""
    if wedges is None or len(faces) == 0:
        return vertices, faces, {}
    keys = faces.astype(np.int64) * (int(wedges.max()) + 1) + wedges
    _, first, of_corner = np.unique(keys, return_index=True, return_inverse=True)
    vertex, wedge = faces.reshape(-1)[first], wedges.reshape(-1)[first]
    corners = of_corner.reshape(-1, 3).astype(np.int32)
    return vertices[vertex], corners, {name: values[wedge] for name, values in attributes.items()}


class NotReachedError(NeuralMeshError):
    """Raised if a result exceeds `error` or `size`, or with `strict=True` any other size; `results` holds what was made."""

    def __init__(self, why: str, results: tuple[Light[Any], ...]) -> None:
        super().__init__(why)
        self.results = results

    def __reduce__(self) -> Any:
        return NotReachedError, (str(self), self.results)

    @property
    def result(self) -> Light[Any]:
        """The result, or the first level of detail."""
        return self.results[0]

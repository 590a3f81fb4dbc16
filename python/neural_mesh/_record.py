"""`record`: a result as a function of the vertices given, for what learns through it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, overload

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import Given, alike, array_of, given
from ._options import Number, Path, Progress, Whole, as_said, n_threads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack


class Record:
    """How a result depends on the vertices given, its connectivity as it is. `positions` takes arrays of numpy, torch and jax, and is
    differentiable in the latter two; `pool` takes features of the vertices along.

    A record can be pickled: what was given goes along, and is simplified again, which gives the same.
    """

    faces: Any
    """The faces of the result, n x 3, of the kind of array that was given."""
    output_vertices: NDArray[np.int32]
    """Result vertex of each input vertex; -1 for an input vertex without one."""

    def __init__(self, vertices: Any, faces: Any, options: Mapping[str, Any], progress: Progress | None = None) -> None:
        source = given((vertices, faces), None, None)
        positions, corners = source.arrays[:2]
        threads = n_threads(options.get("threads"))
        asked = {name: x for name, x in options.items() if name not in ("threads", "weights")}
        # Copies: what was given may change, and torch moves the memory of tensors that go to other processes.
        self._given, self._options = (positions.copy(), corners.copy()), dict(options)
        files = as_said({"weights": options.get("weights")})
        self._native = _native.record(as_said(asked), files, source.arrays, threads, progress)
        self.faces = alike(vertices, self._native.faces)
        self.output_vertices = _with_welded(source, self._native.output_vertices())

    @property
    def n_input(self) -> int:
        """Vertices that `positions` takes."""
        return self._native.sizes()[0]

    @property
    def n_output(self) -> int:
        """Vertices of the result."""
        return self._native.sizes()[1]

    def positions(self, vertices: Any) -> Any:
        """The vertices of the result (n_output x 3) for these (n_input x 3); differentiable for tensors of torch and jax."""
        kind = type(vertices).__module__.partition(".")[0]
        if kind == "torch":
            from . import torch

            return torch.positions(self, vertices)
        if kind in ("jax", "jaxlib"):
            from . import jax

            return jax.positions(self, vertices)
        return self.forward(array_of(vertices))

    def forward(self, vertices: NDArray[Any]) -> NDArray[Any]:
        """As `positions`, for arrays of numpy; computed in double precision."""
        result = self._native.positions(np.ascontiguousarray(vertices, np.float64))
        return result.astype(vertices.dtype if np.issubdtype(vertices.dtype, np.floating) else np.float64, copy=False)

    def backward(self, vertices: NDArray[Any], gradient: NDArray[Any]) -> NDArray[Any]:
        """The gradient of a loss to the vertices given (n_input x 3) from that to the vertices of the result (n_output x 3)."""
        doubles = [np.ascontiguousarray(array, np.float64) for array in (vertices, gradient)]
        return self._native.backward(*doubles).astype(gradient.dtype, copy=False)

    def pool(self, features: Any) -> Any:
        """Features of the vertices (n_input x k) as those of the result (n_output x k): the mean of those that went into each.
        Differentiable for tensors of torch and jax. A vertex that none went into has zeros."""
        kind = type(features).__module__.partition(".")[0]
        if kind == "torch":
            from . import torch

            return torch.pool(self, features)
        if kind in ("jax", "jaxlib"):
            from . import jax

            return jax.pool(self, features)
        features = array_of(features)
        kept = self.output_vertices >= 0
        outputs = self.output_vertices[kept]
        sums = np.zeros((self.n_output, *features.shape[1:]), np.result_type(features, np.float32))
        np.add.at(sums, outputs, features[kept])
        counts = np.maximum(np.bincount(outputs, minlength=self.n_output), 1)
        return (sums / counts.reshape(-1, *[1] * (features.ndim - 1))).astype(sums.dtype, copy=False)

    def __reduce__(self) -> Any:
        return _again, (*self._given, self._options, np.asarray(self._native.faces))

    def __repr__(self) -> str:
        return f"Record({self.n_input} -> {self.n_output} vertices)"


class Recorded(TypedDict, total=False):
    """Options of `record`; exactly one of the first three says what stays."""

    ratio: Number | str | None
    n_vertices: Whole | str | None
    n_faces: Whole | str | None
    optimize: Literal["balanced", "mean", "max", "normals"] | None
    effort: Literal["fast", "standard", "best"] | None
    scores: Literal["bending", "network", "geometry"] | None
    assembly: Literal["closed", "paper"] | None
    weights: Path | None
    keep_components: bool
    lock_boundaries: bool
    subset: bool
    seed: Whole
    threads: Whole | None
    progress: Progress | None


@overload
def record(vertices: list[Any], faces: Sequence[ArrayLike], **options: Unpack[Recorded]) -> list[Record]: ...
@overload
def record(vertices: ArrayLike, faces: ArrayLike, **options: Unpack[Recorded]) -> Record: ...
def record(vertices: Any, faces: Any, **options: Any) -> Any:
    """Simplifies a mesh (vertices n x 3, faces m x 3) and records how the result depends on its vertices. Lists of meshes give a
    list of records.

    Exactly one of `ratio` (a share of the vertices), `n_vertices` and `n_faces` says what stays. `optimize`, `effort`, `scores`,
    `assembly`, `weights`, `keep_components`, `lock_boundaries`, `subset`, `seed`, `threads` and `progress` are those of `simplify`."""
    unknown = [name for name in options if name not in Recorded.__annotations__]
    if unknown:
        raise _native.OptionError(f"record: no such option: {', '.join(unknown)}")
    options = dict(options)
    progress = options.pop("progress", None)
    sizes = {"ratio": "ratio", "n_vertices": "vertices", "n_faces": "faces"}
    said = {sizes[name]: options.pop(name) for name in sizes if name in options}
    said = {name: size for name, size in said.items() if size is not None}
    if len(said) != 1:
        raise _native.OptionError("record: give exactly one of ratio, n_vertices, n_faces")
    options = {**said, **options}
    if isinstance(vertices, (list, tuple)) and len(vertices) > 0 and hasattr(vertices[0], "shape"):
        return [Record(v, f, options, progress) for v, f in zip(vertices, faces, strict=True)]
    return Record(vertices, faces, options, progress)


def _again(vertices: Any, faces: Any, options: Mapping[str, Any], expected: NDArray[np.int32]) -> Record:
    """The record as it was pickled; what another set of instructions, or another version, makes different is refused."""
    again = Record(vertices, faces, options)
    if not np.array_equal(again.faces, expected):
        raise _native.NeuralMeshError("the record was made by another version or on another processor: record the mesh again")
    return again


def _with_welded(source: Given, outputs: NDArray[np.int32]) -> NDArray[np.int32]:
    """Vertices that were welded to another go where that one goes."""
    return source.welded(outputs)

"""Records a simplification as a differentiable function of the input vertices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, overload

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import MeshInput, convert_like, array_of, read_input
from ._options import Number, Path, Progress, Whole, to_native, n_threads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack


class Record:
    """A simplification as a function of the input vertices, with fixed connectivity.

    `positions` maps vertices and `pool` maps vertex features, of numpy, torch or jax; both are differentiable in torch and jax. A
    record can be pickled: the pickle holds the input, which is simplified again on loading.
    """

    faces: Any
    """Faces of the result, m x 3, in the array type of the input vertices."""
    output_vertices: NDArray[np.int32]
    """Result vertex of each input vertex; -1 for an input vertex without one."""

    def __init__(self, vertices: Any, faces: Any, options: Mapping[str, Any], progress: Progress | None = None) -> None:
        source = read_input((vertices, faces), None, None)
        positions, corners = source.arrays[:2]
        threads = n_threads(options.get("threads"))
        settings = {name: x for name, x in options.items() if name not in ("threads", "weights")}
        # Copies, as the caller may change the input, and torch moves the memory of tensors that it sends to other processes.
        self._given, self._options = (positions.copy(), corners.copy()), dict(options)
        files = to_native({"weights": options.get("weights")})
        self._native = _native.record(to_native(settings), files, source.arrays, threads, progress)
        self.faces = convert_like(vertices, self._native.faces)
        self.output_vertices = _spread_to_welded(source, self._native.output_vertices())

    @property
    def n_input(self) -> int:
        """Number of input vertices."""
        return self._native.sizes()[0]

    @property
    def n_output(self) -> int:
        """Number of result vertices."""
        return self._native.sizes()[1]

    def positions(self, vertices: Any) -> Any:
        """Computes the result vertices (n_output x 3) from input vertices (n_input x 3); differentiable for torch and jax."""
        package = type(vertices).__module__.partition(".")[0]
        if package == "torch":
            from . import torch

            return torch.positions(self, vertices)
        if package in ("jax", "jaxlib"):
            from . import jax

            return jax.positions(self, vertices)
        return self.forward(array_of(vertices))

    def forward(self, vertices: NDArray[Any]) -> NDArray[Any]:
        """Computes the result vertices for numpy arrays, in double precision."""
        result = self._native.positions(np.ascontiguousarray(vertices, np.float64))
        return result.astype(vertices.dtype if np.issubdtype(vertices.dtype, np.floating) else np.float64, copy=False)

    def backward(self, vertices: NDArray[Any], gradient: NDArray[Any]) -> NDArray[Any]:
        """Returns the gradient of a loss by the input vertices (n_input x 3), from the one by the result vertices (n_output x 3)."""
        doubles = [np.ascontiguousarray(array, np.float64) for array in (vertices, gradient)]
        return self._native.backward(*doubles).astype(gradient.dtype, copy=False)

    def pool(self, features: Any) -> Any:
        """Averages features of the input vertices (n_input x k) over the vertices merged into each result vertex (n_output x k).

        Differentiable for torch and jax. A result vertex without input vertices gets zeros."""
        package = type(features).__module__.partition(".")[0]
        if package == "torch":
            from . import torch

            return torch.pool(self, features)
        if package in ("jax", "jaxlib"):
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
        return _restore_record, (*self._given, self._options, np.asarray(self._native.faces))

    def __repr__(self) -> str:
        return f"Record({self.n_input} -> {self.n_output} vertices)"


class RecordOptions(TypedDict, total=False):
    """Options of `record`, with exactly one of the sizes `ratio`, `n_vertices` and `n_faces`."""

    ratio: Number | str | None
    n_vertices: Whole | str | None
    n_faces: Whole | str | None
    optimize: Literal["balanced", "mean", "max", "normals", "looks"] | None
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
def record(vertices: list[Any], faces: Sequence[ArrayLike], **options: Unpack[RecordOptions]) -> list[Record]: ...
@overload
def record(vertices: ArrayLike, faces: ArrayLike, **options: Unpack[RecordOptions]) -> Record: ...
def record(vertices: Any, faces: Any, **options: Any) -> Any:
    """Simplifies a mesh (vertices n x 3, faces m x 3) and records how the result depends on the input vertices.

    Lists of vertices and of faces return a list of records. Exactly one size is given: `ratio` (share of the vertices), `n_vertices`
    or `n_faces`. `optimize`, `effort`, `scores`, `assembly`, `weights`, `keep_components`, `lock_boundaries`, `subset`, `seed`,
    `threads` and `progress` are options of `simplify`.

    Raises `OptionError` for an unknown option or not exactly one size."""
    unknown = [name for name in options if name not in RecordOptions.__annotations__]
    if unknown:
        raise _native.OptionError(f"record: no such option: {', '.join(unknown)}")
    options = dict(options)
    progress = options.pop("progress", None)
    sizes = {"ratio": "ratio", "n_vertices": "vertices", "n_faces": "faces"}
    target = {sizes[name]: options.pop(name) for name in sizes if name in options}
    target = {name: size for name, size in target.items() if size is not None}
    if len(target) != 1:
        raise _native.OptionError("record: give exactly one of ratio, n_vertices, n_faces")
    options = {**target, **options}
    if isinstance(vertices, (list, tuple)) and len(vertices) > 0 and hasattr(vertices[0], "shape"):
        return [Record(v, f, options, progress) for v, f in zip(vertices, faces, strict=True)]
    return Record(vertices, faces, options, progress)


def _restore_record(vertices: Any, faces: Any, options: Mapping[str, Any], expected: NDArray[np.int32]) -> Record:
    """Rebuilds a pickled record; rejects it if this version or processor gives other faces."""
    restored = Record(vertices, faces, options)
    if not np.array_equal(restored.faces, expected):
        raise _native.NeuralMeshError("the record was made by another version or on another processor: record the mesh again")
    return restored


def _spread_to_welded(source: MeshInput, outputs: NDArray[np.int32]) -> NDArray[np.int32]:
    """Gives each welded vertex the result vertex of the one it was welded to."""
    return source.spread_to_welded(outputs)

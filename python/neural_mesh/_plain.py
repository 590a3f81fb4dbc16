"""The small path: clean arrays with nothing to keep but their shape go to the kernel of the collapse alone.

A mesh that has to be cleaned, that is no manifold, or that merges alone do not bring to the size takes the whole way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import MeshInput, read_input
from ._options import DEFAULTS, UNASKED, Progress, n_threads, plain, to_native
from ._report import Report
from ._result import Light

# Steps that move vertices nearer to the input after the merges, by `effort`.
_FIT_STEPS = {None: 1, "fast": 0}
_COUNTS = (
    "components_at_minimum",
    "components_pruned",
    "components_hidden",
    "kept_edges",
    "locked_vertices",
    "split_vertices",
    "flipped_edges",
    "separated_vertices",
    "shortened_spikes",
)
_CLEANED = ("welded_vertices", "degenerate_faces", "duplicate_faces", "non_finite_faces", "out_of_range_faces", "dropped_faces")


def is_plain(options: Mapping[str, Any], target: Mapping[str, Any]) -> bool:
    """Returns whether nothing is asked for but a number or share of vertices or faces."""
    if options["effort"] not in _FIT_STEPS or not ("ratio" in target or "vertices" in target or "faces" in target):
        return False
    return all(value is UNASKED[name] or _is_unasked(name, value) for name, value in options.items())


def _is_unasked(name: str, value: Any) -> bool:
    """Returns whether an option changes nothing on the small path; wrong values are for the whole way to refuse."""
    if name in ("seed", "strict", "keep_components", "lock_boundaries", "weld"):
        number = plain(value)
        return isinstance(number, int if name == "seed" else bool) and 0 <= number < 1 << 64
    if name in ("threads", "on_dirty", "effort", "progress") or name == "groups" and value is None:
        return True
    is_scalar = isinstance(value, (bool, np.bool_)) or isinstance(value, np.ndarray) and value.shape == ()
    return is_scalar and not value and name not in DEFAULTS


def only_rising(progress: Progress) -> Progress:
    """Returns a listener that receives the largest share so far, where a second way begins again."""
    largest = 0.0

    def tell(done: float, stage: str) -> object:
        nonlocal largest
        largest = max(largest, done)
        return progress(largest, stage)

    return tell


def is_plain_mesh(source: MeshInput) -> bool:
    """Returns whether a mesh has no data but vertices and faces."""
    return source.arrays is not None and not source.arrays[3] and source.arrays[4] is None and not source.face_values


def simplify_plain(sources: Sequence[MeshInput], target: Mapping[str, Any], options: Mapping[str, Any]) -> list[Light[Any] | None]:
    """Simplifies plain meshes in one call; `None` for each that takes the whole way."""
    if not sources:
        return []
    threads = n_threads(options["threads"])
    fit, locks, welds = _FIT_STEPS[options["effort"]], bool(plain(options["lock_boundaries"])), bool(plain(options["weld"]))
    meshes = [source.arrays[:2] for source in sources]
    progress: Progress | None = options["progress"]
    # Where the whole way follows, the run is not done yet.
    listener: Progress | None = progress and (lambda done, stage: stage == "done" or progress(done, stage))
    results = _native.simplify_plain(to_native(target), meshes, fit, locks, welds, False, threads, listener)
    if results is None:
        return [None] * len(sources)
    if progress and all(results):
        progress(1.0, "done")
    seed = int(options["seed"] or 0)
    return [result and _make_light(result, source, seed) for result, source in zip(results, sources)]


def merge_plain(
    vertices: NDArray[Any], faces: NDArray[Any], n_faces: int, locks_boundaries: bool
) -> tuple[NDArray[Any], NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]] | None:
    """Merges the vertices of a plain mesh down to a number of faces, without a fit.

    Returns vertices, faces, an input vertex of each vertex, and the vertex that each input vertex became (-1 for one without a face);
    `None` for a mesh that takes the whole way."""
    source = read_input((vertices, faces), None, None)
    result = (_native.simplify_plain({"faces": n_faces}, [source.arrays[:2]], 0, locks_boundaries, True, True, 1, None) or [None])[0]
    if result is None or result.became is None:
        return None
    return result.vertices, result.faces, result.origins, result.became


def _make_light(result: _native.PlainResult, source: MeshInput, seed: int) -> Light[Any]:
    vertices, faces = source.convert_like(result.vertices), source.convert_like(result.faces)
    report: Report = {
        "input": {"vertices": result.n_used, "faces": len(source.arrays[1])},
        "output": {"vertices": len(result.vertices), "faces": len(result.faces), **dict.fromkeys(_COUNTS, 0)},  # type: ignore[typeddict-item]
        "target": result.target,
        "outcome": "reached",
        "scores": "geometry",
        "seed": seed,
        "threads": result.threads,
        "seconds": {"read": 0.0, "simplify": result.seconds, "write": 0.0, "check": 0.0, "stages": {}},
        "cleaned": {"unreferenced_vertices": len(source.arrays[0]) - result.n_used, **dict.fromkeys(_CLEANED, 0)},  # type: ignore[typeddict-item]
        "distance": None,
        "estimated_error": result.error,
    }
    light: Light[Any] = Light(vertices, faces, {}, None, None, {}, {}, report, None, None, (), None)
    object.__setattr__(light, "_mesh", source.back(light))
    return light

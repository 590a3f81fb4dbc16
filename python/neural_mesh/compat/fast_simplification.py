"""Replaces `simplify`, `simplify_mesh` and `replay_simplification` of fast_simplification 0.2.

`agg` has no effect, except that 0 keeps all faces. `lossless` keeps the result within a millionth of the diagonal, proved. No component
is dropped. With `return_collapses` points are where `replay_simplification` puts them, so that a replay gives the result; without it they are
nearer to the original. The result of a mesh that has to be cleaned first is not replayed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Light
from .. import simplify as _simplify
from .._plain import merge_plain
from ._replay import check_arrays, replay_simplification
from ._sizes import QUIET, simplify_to_faces, target_faces

__all__ = ["replay_simplification", "simplify", "simplify_mesh"]

_LOSSLESS = "0.0001%"


def simplify(
    points: Any,
    triangles: Any,
    target_reduction: float | None = None,
    target_count: int | None = None,
    agg: float = 7.0,
    verbose: bool = False,
    return_collapses: bool = False,
    lossless: bool = False,
    preserve_border: bool = False,
) -> Any:
    """Simplifies a mesh and returns its points (n x 3, `float64`) and triangles (m x 3, `int32`).

    `target_reduction` is the share of triangles to remove, `target_count` the number to keep. With `return_collapses`, pairs of point
    indices are returned, too: the second of each pair was merged into the first. Raises `ValueError` as the original does."""
    points, triangles = check_arrays(points, triangles)
    *lighter, collapses, is_replayed = _merge(points, triangles, target_reduction, target_count, agg, lossless, preserve_border)
    if not return_collapses:
        return tuple(lighter)
    if is_replayed:
        lighter = list(replay_simplification(points, triangles, collapses, preserve_border)[:2])
    return (*lighter, collapses)


def _merge(
    points: Any, triangles: Any, target_reduction: float | None, target_count: int | None, agg: float, lossless: bool, preserve_border: bool
) -> tuple[NDArray[Any], NDArray[np.int32], NDArray[np.int32], bool]:
    """Returns points, triangles, pairs of points, k x 2 (the second was merged into the first), and whether pairs alone make the triangles."""
    options: dict[str, Any] = {"lock_boundaries": bool(preserve_border), "map": True, **QUIET}
    if lossless:
        return *_from_map(_simplify((points, triangles), error=_LOSSLESS, **options)), False
    n_faces = target_faces(len(triangles), target_reduction, target_count)
    n_faces = n_faces if agg > 0 else len(triangles)
    if not 0 < n_faces < len(triangles):
        return (*simplify_to_faces(points, triangles, n_faces, {}), np.zeros((0, 2), np.int32), False)
    merged = merge_plain(points, triangles, n_faces, bool(preserve_border))
    if merged is None:
        return *_from_map(_simplify((points, triangles), faces=n_faces, **options)), False
    return *_number(*merged), True


def _from_map(light: Light[Any]) -> tuple[NDArray[Any], NDArray[np.int32], NDArray[np.int32]]:
    assert light.map is not None
    return _number(np.asarray(light.vertices), np.asarray(light.faces), light.map.input_vertices, light.map.output_vertices)


def _number(
    vertices: NDArray[Any], faces: NDArray[np.int32], origins: NDArray[np.int32], became: NDArray[np.int32]
) -> tuple[NDArray[Any], NDArray[np.int32], NDArray[np.int32]]:
    """Numbers the vertices in the order of the points that became them."""
    order = np.argsort(origins, kind="stable")
    numbers = np.empty(len(order), np.int32)
    numbers[order] = np.arange(len(order), dtype=np.int32)
    merged = np.flatnonzero(became >= 0)
    pairs = np.stack([origins[became[merged]], merged], axis=1).astype(np.int32)
    # Views, as the original returns them.
    return vertices[order].view(), numbers[faces].view(), pairs[pairs[:, 0] != pairs[:, 1]]


def simplify_mesh(
    mesh: Any,
    target_reduction: float | None = None,
    target_count: int | None = None,
    agg: float = 7.0,
    verbose: bool = False,
    preserve_border: bool = False,
) -> Any:
    """Simplifies a `pyvista.PolyData`; unlike by the original, points that stay keep their point data."""
    if not mesh.is_all_triangles:
        raise ValueError("Input mesh must consist of only triangles")
    import pyvista as pv

    points, triangles = np.asarray(mesh.points), mesh.regular_faces
    vertices, faces, collapses, _ = _merge(points.astype(np.float64), triangles, target_reduction, target_count, agg, False, preserve_border)
    lighter = pv.PolyData.from_regular_faces(vertices.astype(points.dtype), faces)
    lighter.field_data["fast_simplification_collapses"] = collapses
    stays = np.zeros(len(points), bool)
    stays[triangles] = True
    stays[collapses[:, 1]] = False
    if np.count_nonzero(stays) == len(vertices):
        for name in mesh.point_data.keys():
            lighter.point_data[name] = np.asarray(mesh.point_data[name])[stays]
    return lighter

"""Replaces `simplify` and `simplify_mesh` of fast_simplification 0.2.

`agg` has no effect, except that 0 keeps all faces. `lossless` keeps the result within a millionth of the diagonal, proved. No component
is dropped. Points are numbered as by `replay_simplification`, but replayed positions differ, as positions are fitted afterwards here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Light
from .. import simplify as _simplify
from .._plain import merge_plain
from ._sizes import QUIET, simplify_to_faces, target_faces

__all__ = ["simplify", "simplify_mesh"]

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
    points, triangles = np.asarray(points, np.float64), np.asarray(triangles)
    for name, array in (("points", points), ("triangles", triangles)):
        if array.ndim != 2:
            raise ValueError(f"``{name}`` array must be 2 dimensional")
        if array.shape[1] != 3:
            raise ValueError(f"Expected ``{name}`` array to be (n, 3), not {array.shape}")
    lighter = _merge(points, triangles, target_reduction, target_count, agg, lossless, preserve_border)
    return lighter if return_collapses else lighter[:2]


def _merge(
    points: Any, triangles: Any, target_reduction: float | None, target_count: int | None, agg: float, lossless: bool, preserve_border: bool
) -> tuple[NDArray[Any], NDArray[np.int32], NDArray[np.int32]]:
    """Returns points, triangles, and pairs of points, k x 2: the second was merged into the first."""
    options: dict[str, Any] = {"lock_boundaries": bool(preserve_border), "map": True, **QUIET}
    if lossless:
        return _from_map(_simplify((points, triangles), error=_LOSSLESS, **options))
    n_faces = target_faces(len(triangles), target_reduction, target_count)
    n_faces = n_faces if agg > 0 else len(triangles)
    if not 0 < n_faces < len(triangles):
        return (*simplify_to_faces(points, triangles, n_faces, {}), np.zeros((0, 2), np.int32))
    merged = merge_plain(points, triangles, n_faces, bool(preserve_border))
    return _from_map(_simplify((points, triangles), faces=n_faces, **options)) if merged is None else _number(*merged)


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
    vertices, faces, collapses = _merge(points.astype(np.float64), triangles, target_reduction, target_count, agg, False, preserve_border)
    lighter = pv.PolyData.from_regular_faces(vertices.astype(points.dtype), faces)
    lighter.field_data["fast_simplification_collapses"] = collapses
    stays = np.zeros(len(points), bool)
    stays[triangles] = True
    stays[collapses[:, 1]] = False
    if np.count_nonzero(stays) == len(vertices):
        for name in mesh.point_data.keys():
            lighter.point_data[name] = np.asarray(mesh.point_data[name])[stays]
    return lighter

"""Replaces `simplify` and `simplify_mesh` of fast_simplification 0.2.

`agg` has no effect, except that 0 keeps all faces. `lossless` keeps the result within a millionth of the diagonal, proved. No component
is dropped. Points are numbered as by `replay_simplification`, but replayed positions differ, as positions are fitted afterwards here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Light, Map
from .. import simplify as _simplify
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
    options: dict[str, Any] = {"lock_boundaries": bool(preserve_border), "map": True, **QUIET}
    if lossless:
        light = _simplify((points, triangles), error=_LOSSLESS, **options)
    else:
        n_faces = target_faces(len(triangles), target_reduction, target_count)
        n_faces = n_faces if agg > 0 else len(triangles)
        if not 0 < n_faces < len(triangles):
            vertices, faces = simplify_to_faces(points, triangles, n_faces, {})
            return (vertices, faces, np.zeros((0, 2), np.int32)) if return_collapses else (vertices, faces)
        light = _simplify((points, triangles), faces=n_faces, **options)
    vertices, faces = _sort_vertices(light)
    return (vertices, faces, _collapses(light.map)) if return_collapses and light.map is not None else (vertices, faces)


def _sort_vertices(light: Light[Any]) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Returns vertices and faces with the vertices in the order of their closest input points."""
    vertices, faces = np.asarray(light.vertices), np.asarray(light.faces)
    if light.map is None:
        return vertices, faces
    order = np.argsort(light.map.input_vertices, kind="stable")
    numbers = np.empty(len(order), np.int32)
    numbers[order] = np.arange(len(order), dtype=np.int32)
    return vertices[order].view(), numbers[faces].view()


def _collapses(result_map: Map) -> NDArray[np.int32]:
    """Returns pairs of points, k x 2: the second was merged into the first, the input point closest to the result vertex."""
    merged = np.flatnonzero(result_map.output_vertices >= 0)
    targets = result_map.input_vertices[result_map.output_vertices[merged]]
    pairs = np.stack([targets, merged], axis=1).astype(np.int32)
    moved: NDArray[np.int32] = pairs[pairs[:, 0] != pairs[:, 1]]
    return moved


def simplify_mesh(
    mesh: Any,
    target_reduction: float | None = None,
    target_count: int | None = None,
    agg: float = 7.0,
    verbose: bool = False,
    preserve_border: bool = False,
) -> Any:
    """Simplifies a `pyvista.PolyData` and, unlike the original, carries its point data."""
    if not mesh.is_all_triangles:
        raise ValueError("Input mesh must consist of only triangles")
    import pyvista as pv

    points, triangles = np.asarray(mesh.points), mesh.regular_faces
    n_faces = target_faces(mesh.n_cells, target_reduction, target_count) if agg > 0 else mesh.n_cells
    light = _simplify((points, triangles), faces=max(n_faces, 1), lock_boundaries=bool(preserve_border), map=True, **QUIET)
    vertices, faces, result_map = *_sort_vertices(light), light.map
    assert result_map is not None
    lighter = pv.PolyData.from_regular_faces(vertices, faces)
    lighter.field_data["fast_simplification_collapses"] = _collapses(result_map)
    if light.report["input"]["faces"] == len(triangles):
        _carry_point_data(mesh, lighter, faces, triangles, result_map)
    return lighter


def _carry_point_data(mesh: Any, lighter: Any, faces: NDArray[np.int32], triangles: NDArray[Any], result_map: Map) -> None:
    """Carries point data: blends floating-point values at the place of a corner, takes others from the closest point."""
    corner = np.zeros(lighter.n_points, np.int64)
    corner[faces.reshape(-1)] = np.arange(faces.size)
    at, weights = triangles[result_map.corner_faces.reshape(-1)[corner]], result_map.corner_weights.reshape(-1, 3)[corner]
    for name in mesh.point_data.keys():
        values = np.asarray(mesh.point_data[name])
        if np.issubdtype(values.dtype, np.floating) and values.ndim <= 2:
            lighter.point_data[name] = np.einsum("nk,nk...->n...", weights, values[at]).astype(values.dtype)
        elif np.issubdtype(values.dtype, np.number) or values.dtype == np.bool_:
            lighter.point_data[name] = values[np.take_along_axis(at, weights.argmax(1)[:, None], axis=1)[:, 0]]

"""`fast_simplification.simplify` and `simplify_mesh` (0.2), with the same signatures and meaning.

`agg` is a speed there and nothing here, but that with 0 nothing goes. `lossless` means: within a millionth of the diagonal, proved. No component goes. Collapses say
which points went into which, and points are numbered as `replay_simplification` numbers them; replayed positions are others, as ours
are fitted afterwards.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Light, Map
from .. import simplify as _simplify
from ._sizes import QUIET, faces_left, faces_of

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
    """Points (n x 3, `float64`) and triangles (m x 3, `int32`) of the mesh without `target_reduction` of its triangles, or with
    `target_count` of them."""
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
        n_faces = faces_of(len(triangles), target_reduction, target_count)
        n_faces = n_faces if agg > 0 else len(triangles)
        if not 0 < n_faces < len(triangles):
            vertices, faces = faces_left(points, triangles, n_faces, {})
            return (vertices, faces, np.zeros((0, 2), np.int32)) if return_collapses else (vertices, faces)
        light = _simplify((points, triangles), faces=n_faces, **options)
    vertices, faces = _ordered(light)
    return (vertices, faces, _collapses(light.map)) if return_collapses and light.map is not None else (vertices, faces)


def _ordered(light: Light[Any]) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Vertices in the order of the points that stay for them, and faces."""
    vertices, faces = np.asarray(light.vertices), np.asarray(light.faces)
    if light.map is None:
        return vertices, faces
    order = np.argsort(light.map.input_vertices, kind="stable")
    numbers = np.empty(len(order), np.int32)
    numbers[order] = np.arange(len(order), dtype=np.int32)
    return vertices[order].view(), numbers[faces].view()


def _collapses(way: Map) -> NDArray[np.int32]:
    """Pairs of points, the second of which went into the first: the one that is nearest to where they ended."""
    gone = np.flatnonzero(way.output_vertices >= 0)
    into = way.input_vertices[way.output_vertices[gone]]
    pairs = np.stack([into, gone], axis=1).astype(np.int32)
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
    """As `simplify`, of a `pyvista.PolyData`. Numbers of its points come along, which they do not there."""
    if not mesh.is_all_triangles:
        raise ValueError("Input mesh must consist of only triangles")
    import pyvista as pv

    points, triangles = np.asarray(mesh.points), mesh.regular_faces
    n_faces = faces_of(mesh.n_cells, target_reduction, target_count) if agg > 0 else mesh.n_cells
    light = _simplify((points, triangles), faces=max(n_faces, 1), lock_boundaries=bool(preserve_border), map=True, **QUIET)
    vertices, faces, way = *_ordered(light), light.map
    assert way is not None
    lighter = pv.PolyData.from_regular_faces(vertices, faces)
    lighter.field_data["fast_simplification_collapses"] = _collapses(way)
    if light.report["input"]["faces"] == len(triangles):
        _carry(mesh, lighter, faces, triangles, way)
    return lighter


def _carry(mesh: Any, lighter: Any, faces: NDArray[np.int32], triangles: NDArray[Any], way: Map) -> None:
    """Gives each point the values where one of its corners stands on the mesh."""
    corner = np.zeros(lighter.n_points, np.int64)
    corner[faces.reshape(-1)] = np.arange(faces.size)
    at, weights = triangles[way.corner_faces.reshape(-1)[corner]], way.corner_weights.reshape(-1, 3)[corner]
    for name in mesh.point_data.keys():
        values = np.asarray(mesh.point_data[name])
        if np.issubdtype(values.dtype, np.floating) and values.ndim <= 2:
            lighter.point_data[name] = np.einsum("nk,nk...->n...", weights, values[at]).astype(values.dtype)
        elif np.issubdtype(values.dtype, np.number) or values.dtype == np.bool_:
            lighter.point_data[name] = values[np.take_along_axis(at, weights.argmax(1)[:, None], axis=1)[:, 0]]

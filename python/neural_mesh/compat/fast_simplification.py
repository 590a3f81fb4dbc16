"""`fast_simplification.simplify` and `simplify_mesh` (0.2), with the same signatures and meaning.

`agg` is a speed there and nothing here. `lossless` means: within a millionth of the diagonal, proved. Collapses say which points went
into which; to replay them does not give the positions, which are fitted afterwards.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Map
from .. import simplify as _simplify
from ._sizes import faces_left, faces_of

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
    options: dict[str, Any] = {"lock_boundaries": bool(preserve_border), "map": return_collapses}
    if lossless:
        light = _simplify((points, triangles), error=_LOSSLESS, **options)
    else:
        n_faces = faces_of(len(triangles), target_reduction, target_count)
        if not 0 < n_faces < len(triangles):
            vertices, faces = faces_left(points, triangles, n_faces, {})
            return (vertices, faces, np.zeros((0, 2), np.int32)) if return_collapses else (vertices, faces)
        light = _simplify((points, triangles), faces=n_faces, **options)
    both = (np.asarray(light.vertices), np.asarray(light.faces))
    return (*both, _collapses(light.map)) if light.map is not None else both


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
    """As `simplify`, of a `pyvista.PolyData`. What its points carry comes along, which it does not there."""
    if not mesh.is_all_triangles:
        raise ValueError("Input mesh must consist of only triangles")
    n_faces = faces_of(mesh.n_cells, target_reduction, target_count)
    light = _simplify(mesh, faces=max(n_faces, 1), lock_boundaries=bool(preserve_border), map=True)
    assert light.map is not None
    light.mesh.field_data["fast_simplification_collapses"] = _collapses(light.map)
    return light.mesh

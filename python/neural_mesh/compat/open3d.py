"""Replaces the method `simplify_quadric_decimation` of Open3D's meshes by a function."""

from __future__ import annotations

import math
from typing import Any

from .. import simplify as _simplify
from ._sizes import QUIET

__all__ = ["simplify_quadric_decimation"]


def simplify_quadric_decimation(
    mesh: Any, target_number_of_triangles: int, maximum_error: float = math.inf, boundary_weight: float = 1.0
) -> Any:
    """Simplifies a mesh to a number of triangles, or to more if `maximum_error` requires it.

    `maximum_error` is a proved distance to the original in the unit of the mesh. A `boundary_weight` of at least 10 fixes boundaries."""
    options: dict[str, Any] = {"lock_boundaries": boundary_weight >= 10.0, **QUIET}
    light = _simplify(mesh, faces=max(int(target_number_of_triangles), 1), **options)
    if math.isfinite(maximum_error):
        # The search finds the fewest faces within the bound; if these are more than requested, the bound decides.
        bounded = _simplify(mesh, error=float(maximum_error), **options)
        light = max(light, bounded, key=lambda result: len(result.faces))
    return light.mesh

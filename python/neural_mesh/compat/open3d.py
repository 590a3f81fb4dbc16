"""`simplify_quadric_decimation` of Open3D's meshes, with the same meaning: as a function of a mesh."""

from __future__ import annotations

import math
from typing import Any

from .. import simplify as _simplify
from ._sizes import QUIET

__all__ = ["simplify_quadric_decimation"]


def simplify_quadric_decimation(
    mesh: Any, target_number_of_triangles: int, maximum_error: float = math.inf, boundary_weight: float = 1.0
) -> Any:
    """The mesh with so many triangles, or with more where `maximum_error` says so: a distance here, in the unit of the mesh, proved.
    From a `boundary_weight` of ten on boundaries stay as they are; below they are kept near."""
    options: dict[str, Any] = {"lock_boundaries": boundary_weight >= 10.0, **QUIET}
    light = _simplify(mesh, faces=max(int(target_number_of_triangles), 1), **options)
    if math.isfinite(maximum_error):
        # The search gives the fewest within the bound: where that is more than asked for, the bound counts.
        bounded = _simplify(mesh, error=float(maximum_error), **options)
        light = max(light, bounded, key=lambda result: len(result.faces))
    return light.mesh

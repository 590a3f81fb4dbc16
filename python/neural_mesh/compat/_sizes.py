"""Converts the sizes of other packages, which count removed faces, to numbers of remaining faces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import simplify

# The other packages drop no components and do not warn of cleaning.
QUIET: dict[str, Any] = {"keep_components": True, "on_dirty": "ignore"}


def simplify_to_faces(vertices: Any, faces: Any, n_faces: int, options: dict[str, Any]) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Returns vertices and faces of the mesh, simplified to at most `n_faces` faces; 0 returns an empty mesh."""
    if len(faces) <= n_faces:
        return np.array(vertices), np.array(faces, np.int32)
    if n_faces <= 0 or len(faces) == 0:
        return np.zeros((0, 3), np.asarray(vertices).dtype), np.zeros((0, 3), np.int32)
    light = simplify((vertices, faces), faces=n_faces, **{**QUIET, **options})
    return np.asarray(light.vertices), np.asarray(light.faces)


def target_faces(n_faces: int, target_reduction: float | None, target_count: int | None) -> int:
    """Returns the number of faces to keep; raises the same errors as fast_simplification."""
    if target_reduction and target_count:
        raise ValueError("You may specify ``target_reduction`` or ``target_count``, but not both")
    if target_reduction is not None:
        if not 0 <= target_reduction <= 1:
            raise ValueError("``target_reduction`` must be between 0 and 1")
        return int((1 - target_reduction) * n_faces)
    if target_count is None:
        raise ValueError("You must specify ``target_reduction`` or ``target_count``")
    if target_count < 0:
        raise ValueError("``target_count`` must be greater than 0")
    if target_count > n_faces:
        raise ValueError(f"``target_count`` must be less than the number of faces {n_faces}")
    return int(target_count)

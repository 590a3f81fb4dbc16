"""Replaces the class `pyfqmr.Simplify`.

The parameters of its thresholds (`update_rate`, `aggressiveness`, `max_iterations`, `alpha`, `K`) have no effect.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import simplify as _simplify
from ._sizes import QUIET, simplify_to_faces

__all__ = ["Simplify"]


class Simplify:
    """A mesh that is simplified in place: `setMesh`, `simplify_mesh`, `getMesh`."""

    def __init__(self) -> None:
        self._vertices: NDArray[Any] = np.zeros((0, 3))
        self._faces: NDArray[Any] = np.zeros((0, 3), np.int32)

    def setMesh(self, vertices: Any, faces: Any, face_colors: Any = None) -> None:
        """Sets the mesh: vertices n x 3, faces m x 3 of integers. `face_colors` have no effect."""
        if not np.issubdtype(np.asarray(faces).dtype, np.integer):
            raise TypeError("faces array must be of integer type")
        self._vertices = np.array(vertices, np.float64)
        self._faces = np.array(faces, np.int32)

    def simplify_mesh(
        self,
        target_count: int = 100,
        update_rate: int = 5,
        aggressiveness: float = 7.0,
        max_iterations: int = 100,
        verbose: bool = True,
        lossless: bool = False,
        threshold_lossless: float = 1e-3,
        alpha: float = 1e-9,
        K: int = 3,
        preserve_border: bool = True,
    ) -> None:
        """Simplifies to `target_count` faces, or with `lossless` as `simplify_mesh_lossless`. `preserve_border` fixes the boundary."""
        options: dict[str, Any] = {"lock_boundaries": bool(preserve_border)}
        if lossless:
            self._simplify_within(threshold_lossless, options)
        else:
            self._vertices, self._faces = simplify_to_faces(self._vertices, self._faces, target_count, options)

    def simplify_mesh_lossless(
        self, verbose: bool = True, epsilon: float = 1e-3, max_iterations: int = 9999, preserve_border: bool = False
    ) -> None:
        """Simplifies to the fewest faces within a proved distance of a third of the root of `epsilon`.

        `epsilon` is a bound of squared distances in the original; its results are that far from the mesh."""
        self._simplify_within(epsilon, {"lock_boundaries": bool(preserve_border)})

    def _simplify_within(self, squared: float, options: dict[str, Any]) -> None:
        if len(self._faces) == 0:
            return
        light = _simplify((self._vertices, self._faces), error=math.sqrt(max(squared, 0.0)) / 3, **{**QUIET, **options})
        self._vertices, self._faces = np.asarray(light.vertices), np.asarray(light.faces)

    def getMesh(self) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
        """Returns vertices (n x 3), faces (m x 3), and unit normals of the faces (m x 3)."""
        corners = self._vertices[self._faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return self._vertices, self._faces, normals / np.where(lengths > 0, lengths, 1)

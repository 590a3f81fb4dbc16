"""Carries face values that do not constrain the simplification: each result face takes those of the closest input face."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ._meshes import MeshInput
    from ._report import Report
    from ._result import Map


def carry_face_values(source: MeshInput, report: Report, corner_map: Map | None) -> tuple[dict[str, NDArray[Any]], str]:
    """Returns the values of the result's faces by name, and the reason if they are lost."""
    if not source.face_values:
        return {}, ""
    names = ", ".join(source.face_values)
    if corner_map is None:
        return {}, f"lost: values of faces ({names}): levels of detail cannot carry them"
    left = find_clean_faces(source.arrays[0], source.arrays[1], report["input"]["faces"])
    if left is None:
        return {}, f"lost: values of faces ({names}): too many faces were cleaned"
    faces = left[_nearest_faces(source, left, corner_map)] if len(corner_map.corner_faces) else np.zeros(0, np.int64)
    return {name: values[faces] for name, values in source.face_values.items()}, ""


def find_clean_faces(vertices: NDArray[Any], faces: NDArray[Any], n_clean: int, weld: bool = True) -> NDArray[np.int64] | None:
    """Returns the indices of the input faces that cleaning kept, in the order in which `Map.corner_faces` numbers them.

    `vertices` is n x 3, `faces` m x 3, `n_clean` is `light.report["input"]["faces"]`, and `weld` is the option given to `simplify`.
    Returns `None` if faces were removed that are neither degenerate nor duplicates nor invalid.
    """
    if len(faces) == n_clean:
        return np.arange(n_clean)
    named = (faces < len(vertices)).all(1)
    finite = np.zeros(len(faces), bool)
    finite[named] = np.isfinite(vertices[faces[named]]).all((1, 2))
    corners = np.where(finite[:, None], faces, 0)
    if weld:
        _, ids = np.unique(vertices + 0, axis=0, return_inverse=True)
        corners = ids.reshape(-1)[corners]
    a, b, c = corners.T
    clean = np.flatnonzero(finite & (a != b) & (b != c) & (c != a))
    if len(clean) != n_clean:
        _, first = np.unique(np.sort(corners[clean], axis=1), axis=0, return_index=True)
        clean = clean[np.sort(first)]
    return clean if len(clean) == n_clean else None


def _nearest_faces(source: MeshInput, left: NDArray[np.int64], corner_map: Map) -> NDArray[Any]:
    """Returns for each result face the input face closest to its center, among those that its corners are on."""
    vertices, faces = source.arrays[0], source.arrays[1][left]
    points = (vertices[faces[corner_map.corner_faces]] * corner_map.corner_weights[..., None]).sum(2)
    middles = vertices[faces[corner_map.corner_faces]].mean(2)
    distances = ((middles - points.mean(1, keepdims=True)) ** 2).sum(2)
    chosen: NDArray[Any] = np.take_along_axis(corner_map.corner_faces, distances.argmin(1)[:, None], axis=1)[:, 0]
    return chosen

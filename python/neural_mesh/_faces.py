"""Values of faces that hold nothing: each face of a result has those of the given face that it lies on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ._meshes import Given
    from ._report import Report
    from ._result import Map


def carried(source: Given, report: Report, way: Map | None) -> tuple[dict[str, NDArray[Any]], str]:
    """The values of the result's faces by name; or why there are none."""
    if not source.of_faces:
        return {}, ""
    names = ", ".join(source.of_faces)
    if way is None:
        return {}, f"lost: values of faces ({names}): levels of detail cannot carry them"
    left = find_clean_faces(source.arrays[0], source.arrays[1], report["input"]["faces"])
    if left is None:
        return {}, f"lost: values of faces ({names}): too many faces were cleaned"
    faces = left[_nearest(source, left, way)] if len(way.corner_faces) else np.zeros(0, np.int64)
    return {name: values[faces] for name, values in source.of_faces.items()}, ""


def find_clean_faces(vertices: NDArray[Any], faces: NDArray[Any], n_clean: int, weld: bool = True) -> NDArray[np.int64] | None:
    """Returns the faces (m x 3) that cleaning has left, of which there are `n_clean`: those that `Map.corner_faces` numbers.

    `n_clean` is `light.report["input"]["faces"]`, and `weld` as `simplify` had it. Returns `None` where other faces were cleaned than
    degenerate, repeated and broken ones.
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


def _nearest(source: Given, left: NDArray[np.int64], way: Map) -> NDArray[Any]:
    """Of the faces that the corners of each face stand on the one whose middle is nearest to that of the face."""
    vertices, faces = source.arrays[0], source.arrays[1][left]
    points = (vertices[faces[way.corner_faces]] * way.corner_weights[..., None]).sum(2)
    middles = vertices[faces[way.corner_faces]].mean(2)
    distances = ((middles - points.mean(1, keepdims=True)) ** 2).sum(2)
    chosen: NDArray[Any] = np.take_along_axis(way.corner_faces, distances.argmin(1)[:, None], axis=1)[:, 0]
    return chosen

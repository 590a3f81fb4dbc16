"""Replays merges of points: what became one point, and where it is, by the merges and the mesh alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Weight of the mean of merged points in addition to the planes around them, which may leave a direction open.
_PULL = 1e-3


def check_arrays(points: Any, triangles: Any) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Returns points and triangles as arrays; raises `ValueError` as fast_simplification does for other shapes."""
    points, triangles = np.asarray(points, np.float64), np.asarray(triangles)
    for name, array in (("points", points), ("triangles", triangles)):
        if array.ndim != 2:
            raise ValueError(f"``{name}`` array must be 2 dimensional")
        if array.shape[1] != 3:
            raise ValueError(f"Expected ``{name}`` array to be (n, 3), not {array.shape}")
    return points, triangles


def replay_simplification(
    points: Any, triangles: Any, collapses: Any, preserve_border: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int64]]:
    """Merges the second point of each pair into the first, and returns points, triangles, and the new number of each point.

    A point of the result is where the planes of the triangles around its merged points are nearest in the mean square. The mesh may have
    moved since its `simplify(..., return_collapses=True)`. A point without a triangle gets -1. With `preserve_border` points of boundaries
    stay, for collapses that were made so."""
    points, triangles = check_arrays(points, triangles)
    pairs = np.asarray(collapses, np.int64).reshape(-1, 2)
    is_used = np.zeros(len(points), bool)
    is_used[triangles] = True
    if not is_used[pairs].all():
        raise ValueError("``collapses`` references a vertex that is not part of any triangle: they are of another mesh")
    became = np.arange(len(points))
    became[pairs[:, 1]] = pairs[:, 0]
    is_merged = became != np.arange(len(points))
    # Merged points may have been merged again: each round follows twice as many merges.
    for _ in range(len(points).bit_length()):
        further = became[became]
        if (further == became).all():
            break
        became = further
    if is_merged[became].any():
        raise ValueError("``collapses`` merges points in a circle: they are of another mesh")
    kept = np.unique(became[is_used])
    numbers = np.full(len(points), -1)
    numbers[kept] = np.arange(len(kept))
    numbers = np.where(is_used, numbers[became], -1)
    faces = numbers[triangles]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    placed = _place(points, triangles, numbers, kept, preserve_border)
    return placed, faces.astype(np.int32), numbers


def _place(
    points: NDArray[np.float64], triangles: NDArray[Any], numbers: NDArray[Any], kept: NDArray[Any], preserve_border: bool
) -> NDArray[np.float64]:
    """Returns the position of each merged point, k x 3."""
    n, corners = len(kept), points[triangles]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(crosses, axis=1)
    normals = crosses / np.maximum(doubled, 1e-300)[:, None]
    # Each edge of one triangle has a plane across the triangle, so that boundaries stay where they are.
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    _, edge, counts = np.unique(edges.min(1) * len(points) + edges.max(1), return_inverse=True, return_counts=True)
    border = np.flatnonzero(counts[edge] == 1)
    ends = edges[border]
    across = np.cross(points[ends[:, 1]] - points[ends[:, 0]], normals[border // 3])
    lengths = np.linalg.norm(across, axis=1)
    # Every plane, at each point that it counts for: normal, weight, a point of the plane, and the merged point.
    planes = np.concatenate([np.repeat(normals, 3, 0), np.repeat(across / np.maximum(lengths, 1e-300)[:, None], 2, 0)])
    weights = np.concatenate([np.repeat(doubled, 3), np.repeat(lengths**2, 2)])
    bases = np.concatenate([np.repeat(corners[:, 0], 3, 0), np.repeat(points[ends[:, 0]], 2, 0)])
    groups = numbers[np.concatenate([triangles.ravel(), ends.ravel()])]
    members = np.flatnonzero(numbers >= 0)
    sizes = np.bincount(numbers[members], minlength=n)
    add: Any = lambda values, of: np.stack([np.bincount(of, column, n) for column in values.T], axis=1)
    means = add(points[members], numbers[members]) / sizes[:, None]
    offsets = ((bases - means[groups]) * planes).sum(1)
    products = planes[:, :, None] * planes[:, None, :] * weights[:, None, None]
    matrices = add(products.reshape(-1, 9), groups).reshape(-1, 3, 3)
    matrices += (_PULL * np.trace(matrices, axis1=1, axis2=2) + 1e-300)[:, None, None] * np.eye(3)
    right = add(planes * (weights * offsets)[:, None], groups)
    placed: NDArray[np.float64] = means + np.linalg.solve(matrices, right[:, :, None])[:, :, 0]
    # What was not merged keeps its digits, as does what holds a boundary.
    placed[sizes == 1] = points[kept[sizes == 1]]
    if preserve_border:
        placed[numbers[ends]] = points[ends]
    return placed

"""Test meshes, generated here or shipped with the project."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

MESHES = Path(__file__).resolve().parents[2] / "tests" / "meshes"

Pair = tuple[NDArray[Any], NDArray[np.int32]]


def torus(n: int, m: int, dtype: Any = np.float32) -> Pair:
    """Returns a closed, bumpy torus with 2 n m faces."""
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    r = 0.3 + 0.03 * np.sin(5 * u) * np.cos(3 * v)
    points = np.stack([(1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], axis=-1)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b, c, d = (((i + di) % n * m + (j + dj) % m).reshape(-1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return points.reshape(-1, 3).astype(dtype), faces.astype(np.int32)


def grid(n: int) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Returns a flat square with a bump, 2 n^2 faces, and texture coordinates in two charts with a seam at x = 0.5."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    points = np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(4 * y)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b, c, d = (((i + di) * (n + 1) + j + dj).reshape(-1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    uv = points[:, :2][faces]
    uv[points[faces].mean(1)[:, 0] > 0.5] += 2.0
    return points, faces, uv


def edge_counts(faces: NDArray[Any]) -> NDArray[Any]:
    """Returns the number of faces of each edge."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    counts: NDArray[Any] = np.unique(edges, axis=0, return_counts=True)[1]
    return counts


@pytest.fixture(scope="session")
def spot() -> Path:
    return MESHES / "spot.ply"

"""The guide's recipes on meshes like those of generators: unshared vertices, floating components, inner shells, holes."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import edge_counts
from test_guide import RECIPES


def voxel_surface(solid: Any) -> tuple[Any, Any]:
    """Returns the boundary of solid voxels as triangles that share no vertices."""
    padded = np.pad(solid, 1)
    corners, n = [], 0
    for axis in range(3):
        for side in (0, 1):
            other = np.roll(padded, 1 - 2 * side, axis)
            cells = np.argwhere(padded & ~other) - 1
            u, v = (axis + 1) % 3, (axis + 2) % 3
            quad = np.zeros((4, 3))
            quad[:, axis] = side
            quad[[1, 2], u] = 1
            quad[[2, 3], v] = 1
            corners.append(cells[:, None] + (quad if side else quad[::-1]))
            n += len(cells)
    vertices = np.concatenate(corners).reshape(-1, 3)
    first = 4 * np.arange(n)[:, None]
    return vertices, np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]).astype(np.int64)


def shape(n: int) -> Any:
    """Returns a voxel torus with a cavity, and three floating components."""
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    tube = np.hypot(np.hypot(x, y) - 0.6, z)
    solid = (tube < 0.3) & (tube > 0.12)
    for at in (2, n // 2, n - 3):
        solid[at, at, 1 if at != n // 2 else n - 2] = True
    return solid


def tube_distance(vertices: Any) -> Any:
    """Returns the distances of points from the center line of the tube."""
    x, y, z = (np.asarray(vertices) / 36 - 1).T
    return np.hypot(np.hypot(x, y) - 0.6, z)


@pytest.fixture(scope="module")
def recipes() -> dict[str, Any]:
    (block,) = [code for code in re.findall(r"```python\n(.*?)```", RECIPES.read_text(), re.DOTALL) if "def reduce_faces" in code]
    names: dict[str, Any] = {"nm": nm}
    exec(compile(block, str(RECIPES), "exec"), names)
    return names


def test_reduce_generated_mesh(recipes: dict[str, Any]) -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*voxel_surface(shape(72)), process=False)
    light = recipes["reduce_faces"](mesh, max_facenum=3000)
    # The floating components are dropped, both shells are closed, and the size is met.
    assert light.is_watertight and 2990 <= len(light.faces) <= 3000
    tube = tube_distance(light.vertices)
    assert tube.max() < 0.36 and tube.min() < 0.15


def test_drop_hidden_surfaces_and_fill_holes(recipes: dict[str, Any]) -> None:
    vertices, faces = voxel_surface(shape(72))
    x, y, z = (vertices[faces].mean(1) - 36).T / 36
    is_hole = (np.hypot(x - 0.9, y) < 0.06) & (abs(z) < 0.06)
    assert is_hole.any()
    v, f = recipes["postprocess_mesh"](vertices, faces[~is_hole])
    assert (edge_counts(f) == 2).all()
    assert len(v) < 0.06 * len(np.unique(vertices, axis=0))
    # The cavity is gone.
    assert tube_distance(v).min() > 0.2

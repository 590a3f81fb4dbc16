"""Simplification in blocks: the result is closed, close to the original, and independent of the workers."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh

import neural_mesh as nm
from conftest import torus
from neural_mesh import blocks


@pytest.fixture(scope="module")
def mesh() -> tuple[np.ndarray, np.ndarray]:
    """Returns a mesh of 1.2 million faces, which makes three blocks."""
    vertices, faces = torus(1200, 500)
    return np.asarray(vertices, np.float32), faces


def test_joined_mesh_is_closed_and_close(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    whole = blocks.cut(mesh)
    assert len(whole.blocks) == 3 and whole.n_vertices == len(mesh[0])
    assert sum(len(block.faces) for block in whole.blocks) == len(mesh[1])
    vertices, faces = blocks.simplify(whole, ratio=0.01)
    assert len(vertices) == whole.n_vertices // 100
    result = trimesh.Trimesh(vertices, faces, process=False)
    assert result.is_watertight and result.euler_number == 0
    light = nm.simplify(mesh, ratio=0.01)
    ours, theirs = (result["distance_mean"] for result in nm.compare(mesh, (vertices, faces), light).results)
    assert ours is not None and theirs is not None and ours <= 1.1 * theirs


def test_result_is_independent_of_workers(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    far = (np.asarray(mesh[0], np.float64) + [4e6, 0, 0], mesh[1])
    alone = blocks.simplify(far, ratio=0.01, threads=1)
    with ThreadPoolExecutor(3) as pool:
        several = blocks.simplify(far, ratio=0.01, each=pool.map)
    assert all((x == y).all() for x, y in zip(alone, several, strict=True))
    assert alone[0].dtype == np.float64 and abs(alone[0][:, 0].mean() - 4e6) < 0.1


def test_blocks_can_be_pickled(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    block = blocks.cut(mesh).blocks[0]
    again = pickle.loads(pickle.dumps(block))
    paid = blocks.sample(again, 0.01, scores="geometry")
    assert pickle.loads(pickle.dumps(paid)) == paid and paid.n_shared == block.shared.sum()
    price = blocks.price([paid], 0.02)
    lighter = blocks.lighten(again, 0.02, price, scores="geometry")
    assert paid.n_shared < len(lighter.vertices) < 0.03 * len(block.vertices) + paid.n_shared
    assert lighter.shared.sum() >= paid.n_shared


def test_invalid_blocks_are_rejected() -> None:
    corners, face = np.zeros((3, 3), np.float32), np.array([[0, 1, 2]], np.int32)
    with pytest.raises(nm.NeuralMeshError, match="shared: 2 values"):
        blocks.join([blocks.Block(corners, face, np.zeros(2, bool))])
    with pytest.raises(nm.NeuralMeshError):
        blocks.join([blocks.Block(corners, face + 1, np.zeros(3, bool))])
    with pytest.raises(nm.OptionError, match="scores"):
        blocks.sample(blocks.Block(corners, face, np.zeros(3, bool)), 0.1, scores="luck")  # type: ignore[arg-type]
    with pytest.raises(nm.OptionError, match="ratio"):
        blocks.simplify((corners, face), ratio=2)

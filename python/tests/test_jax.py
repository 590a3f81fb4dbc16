"""Records in JAX."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

jax = pytest.importorskip("jax")

import neural_mesh as nm  # noqa: E402
from conftest import torus  # noqa: E402


@pytest.fixture(autouse=True)
def use_double_precision() -> Any:
    with jax.enable_x64(True):
        yield


def mesh() -> tuple[Any, Any]:
    vertices, faces = torus(12, 10, np.float64)
    vertices += np.random.default_rng(3).normal(scale=2e-3, size=vertices.shape)
    return jax.numpy.asarray(vertices), jax.numpy.asarray(faces)


def test_gradients_match_differences_also_jitted() -> None:
    from jax.test_util import check_grads

    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    assert isinstance(record.faces, jax.Array)
    check_grads(record.positions, (vertices,), order=1, modes=["rev"], eps=1e-6, atol=1e-4, rtol=1e-4)
    check_grads(record.pool, (vertices,), order=1, modes=["rev"])

    def loss(v: Any) -> Any:
        return (record.positions(v) ** 2).sum()

    np.testing.assert_allclose(jax.jit(jax.grad(loss))(vertices), jax.grad(loss)(vertices))


def test_matches_numpy() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    np.testing.assert_allclose(record.positions(vertices), record.positions(np.asarray(vertices)))
    np.testing.assert_allclose(record.pool(vertices), record.pool(np.asarray(vertices)))


def test_vmap() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    batch = jax.numpy.stack([vertices, vertices * 2])
    result = jax.vmap(record.positions)(batch)
    np.testing.assert_allclose(result[1], record.positions(batch[1]))
    gradient = jax.vmap(jax.grad(lambda v: (record.positions(v) ** 2).sum()))(batch)
    np.testing.assert_allclose(gradient[1], jax.grad(lambda v: (record.positions(v) ** 2).sum())(batch[1]))

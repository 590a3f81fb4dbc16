"""Differentiates records in JAX: `positions` for vertices, `pool` for vertex features.

`positions` runs on the CPU in double precision by `pure_callback`; it supports `jit` and first derivatives. `vmap` runs sequentially.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ._native import NeuralMeshError
from ._record import Record

__all__ = ["pool", "positions"]


def positions(record: Record, vertices: Any) -> Any:
    """Computes the result vertices (n_output x 3) from input vertices (n_input x 3); differentiable."""
    if vertices.shape != (record.n_input, 3):
        raise NeuralMeshError(f"vertices: an array of shape {vertices.shape}: give {record.n_input} x 3")
    return _positions(record, vertices)


def pool(record: Record, features: Any) -> Any:
    """Averages features of the input vertices (n_input x k) over the vertices merged into each result vertex (n_output x k)."""
    kept = np.flatnonzero(record.output_vertices >= 0)
    outputs = record.output_vertices[kept]
    shares = 1.0 / np.bincount(outputs, minlength=record.n_output)[outputs]
    shares = jnp.asarray(shares.reshape(-1, *[1] * (features.ndim - 1)), features.dtype)
    return jnp.zeros((record.n_output, *features.shape[1:]), features.dtype).at[outputs].add(features[kept] * shares)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _positions(record: Record, vertices: Any) -> Any:
    shape = jax.ShapeDtypeStruct((record.n_output, 3), vertices.dtype)
    return jax.pure_callback(lambda v: record.forward(np.asarray(v)), shape, vertices, vmap_method="sequential")


def _forward(record: Record, vertices: Any) -> tuple[Any, Any]:
    return _positions(record, vertices), vertices


def _backward(record: Record, vertices: Any, gradient: Any) -> tuple[Any]:
    shape = jax.ShapeDtypeStruct((record.n_input, 3), vertices.dtype)

    def to_vertices(v: Any, g: Any) -> Any:
        return record.backward(np.asarray(v), np.asarray(g))

    return (jax.pure_callback(to_vertices, shape, vertices, gradient, vmap_method="sequential"),)


_positions.defvjp(_forward, _backward)

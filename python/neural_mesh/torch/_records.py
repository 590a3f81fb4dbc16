"""Differentiates records in PyTorch: positions of the result, and pooling.

`positions` runs on the CPU in double precision; tensors of a GPU are copied there and back, with one warning. It works under
`torch.compile` as a custom operator.
"""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from .._native import NeuralMeshError
from .._record import Record
from ._arrays import as_numpy

# Operators take tensors and numbers, so records are passed by number. The caller and each autograd graph keep their record alive.
_NUMBERS = itertools.count(1)
_RECORDS: weakref.WeakValueDictionary[int, Record] = weakref.WeakValueDictionary()


def positions(record: Record | Sequence[Record], vertices: Any) -> Any:
    """Computes the result vertices (n_output x 3) from input vertices (n_input x 3); differentiable. Lists return a list."""
    if isinstance(record, (list, tuple)):
        return [positions(one, v) for one, v in zip(record, vertices, strict=True)]
    assert isinstance(record, Record)
    if vertices.shape != (record.n_input, 3):
        raise NeuralMeshError(f"vertices: a tensor of shape {tuple(vertices.shape)}: give {record.n_input} x 3")
    return _positions(vertices, _record_number(record), record.n_output)


def pool(record: Record | Sequence[Record], features: Any) -> Any:
    """Averages features of the input vertices (n_input x k) over the vertices merged into each result vertex (n_output x k).

    Differentiable. Lists of records and features return a list."""
    if isinstance(record, (list, tuple)):
        return [pool(one, x) for one, x in zip(record, features, strict=True)]
    assert isinstance(record, Record)
    kept, outputs, shares = _pooling_weights(record, features.device)
    shape = (record.n_output, *features.shape[1:])
    weighted = features[kept] * shares.to(features.dtype).reshape(-1, *[1] * (features.dim() - 1))
    return features.new_zeros(shape).index_add(0, outputs, weighted)


def _record_number(record: Record) -> int:
    """Returns the number of a record in this process, and registers the record if it has none."""
    number: int | None = record.__dict__.get("_number")
    if number is None or _RECORDS.get(number) is not record:
        number = next(_NUMBERS)
        record.__dict__["_number"] = number
        _RECORDS[number] = record
    return number


def _pooling_weights(record: Record, device: Any) -> tuple[Any, Any, Any]:
    """Returns the input vertices that have a result vertex, these result vertices, and the weights of the mean."""
    kept = np.flatnonzero(record.output_vertices >= 0)
    outputs = record.output_vertices[kept].astype(np.int64)
    shares = 1.0 / np.bincount(outputs, minlength=record.n_output)[outputs]
    return tuple(torch.from_numpy(array).to(device) for array in (kept, outputs, shares))  # type: ignore[return-value]


@torch.library.custom_op("neural_mesh::positions", mutates_args=())
def _positions(vertices: torch.Tensor, number: int, n_output: int) -> torch.Tensor:
    result = torch.from_numpy(_RECORDS[number].forward(as_numpy(vertices, torch.float64)))
    return result.to(vertices.device, vertices.dtype)


@_positions.register_fake
def _(vertices: torch.Tensor, number: int, n_output: int) -> torch.Tensor:
    return vertices.new_empty((n_output, 3))


@torch.library.custom_op("neural_mesh::positions_backward", mutates_args=())
def _positions_backward(vertices: torch.Tensor, gradient: torch.Tensor, number: int) -> torch.Tensor:
    result = torch.from_numpy(_RECORDS[number].backward(as_numpy(vertices, torch.float64), as_numpy(gradient, torch.float64)))
    return result.to(vertices.device, vertices.dtype)


@_positions_backward.register_fake
def _(vertices: torch.Tensor, gradient: torch.Tensor, number: int) -> torch.Tensor:
    return torch.empty_like(vertices, memory_format=torch.contiguous_format)


def _save_context(ctx: Any, inputs: tuple[Any, int, int], output: Any) -> None:
    vertices, ctx.number, _ = inputs
    ctx.save_for_backward(vertices)
    # While `torch.compile` traces there is no record to keep alive.
    ctx.record = _RECORDS.get(ctx.number) if isinstance(ctx.number, int) else None


def _backward(ctx: Any, gradient: Any) -> tuple[Any, None, None]:
    (vertices,) = ctx.saved_tensors
    return _positions_backward(vertices, gradient, ctx.number), None, None


_positions.register_autograd(_backward, setup_context=_save_context)

"""Records in PyTorch: `positions` as a custom operator, `pool` for features of vertices; `expected`, for importance that learns; and
the network as modules (`Network`).

`positions` runs on the processor, in double precision; tensors of a GPU are copied there and back, which a warning says once. It
works under `torch.compile`: the operator is opaque, and its shape is known.
"""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from ._native import NeuralMeshError
from ._record import Record
from ._torch_arrays import as_numpy
from ._torch_expected import expected
from ._torch_graphs import (
    CandidateFaces,
    candidate_faces,
    edges_of_faces,
    extended_graph,
    in_edge_lengths,
    triangle_graph,
    vertex_normals,
)
from ._torch_network import EdgePredictor, Edges, FaceClassifier, Network, PointSampler

__all__ = [
    "CandidateFaces",
    "EdgePredictor",
    "Edges",
    "FaceClassifier",
    "Network",
    "PointSampler",
    "candidate_faces",
    "edges_of_faces",
    "expected",
    "extended_graph",
    "in_edge_lengths",
    "pool",
    "positions",
    "triangle_graph",
    "vertex_normals",
]

# An operator takes tensors and numbers: records go by number. Whoever needs one holds it: the caller, and each graph for its backward.
_NUMBERS = itertools.count(1)
_RECORDS: weakref.WeakValueDictionary[int, Record] = weakref.WeakValueDictionary()


def positions(record: Record | Sequence[Record], vertices: Any) -> Any:
    """The vertices of the result (n_output x 3) for these (n_input x 3), differentiable; of lists of records and of vertices a list."""
    if isinstance(record, (list, tuple)):
        return [positions(one, v) for one, v in zip(record, vertices, strict=True)]
    assert isinstance(record, Record)
    if vertices.shape != (record.n_input, 3):
        raise NeuralMeshError(f"vertices: a tensor of shape {tuple(vertices.shape)}: give {record.n_input} x 3")
    return _positions(vertices, _number(record), record.n_output)


def pool(record: Record | Sequence[Record], features: Any) -> Any:
    """Features of vertices (n_input x k) as those of the result (n_output x k): means of those that went into each; of lists a
    list."""
    if isinstance(record, (list, tuple)):
        return [pool(one, x) for one, x in zip(record, features, strict=True)]
    assert isinstance(record, Record)
    kept, outputs, shares = _pooling(record, features.device)
    shape = (record.n_output, *features.shape[1:])
    weighted = features[kept] * shares.to(features.dtype).reshape(-1, *[1] * (features.dim() - 1))
    return features.new_zeros(shape).index_add(0, outputs, weighted)


def _number(record: Record) -> int:
    """The number of a record in this process."""
    number: int | None = record.__dict__.get("_number")
    if number is None or _RECORDS.get(number) is not record:
        number = next(_NUMBERS)
        record.__dict__["_number"] = number
        _RECORDS[number] = record
    return number


def _pooling(record: Record, device: Any) -> tuple[Any, Any, Any]:
    """Vertices that went anywhere, where they went, and their shares there."""
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


def _setup(ctx: Any, inputs: tuple[Any, int, int], output: Any) -> None:
    vertices, ctx.number, _ = inputs
    ctx.save_for_backward(vertices)
    # While a compiler looks there is no record to hold.
    ctx.record = _RECORDS.get(ctx.number) if isinstance(ctx.number, int) else None


def _backward(ctx: Any, gradient: Any) -> tuple[Any, None, None]:
    (vertices,) = ctx.saved_tensors
    return _positions_backward(vertices, gradient, ctx.number), None, None


_positions.register_autograd(_backward, setup_context=_setup)

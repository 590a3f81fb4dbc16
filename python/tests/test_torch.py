"""Records as operators of PyTorch."""

from __future__ import annotations

import gc
import pickle
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch as nmt  # noqa: E402
from neural_mesh.torch import _arrays, _records  # noqa: E402
from conftest import torus  # noqa: E402


def mesh(dtype: Any = None, n: int = 12, m: int = 10) -> tuple[Any, Any]:
    vertices, faces = torus(n, m, np.float64)
    # The mesh has no flat regions, as the fit is not differentiable where they fit exactly.
    vertices += np.random.default_rng(3).normal(scale=2e-3, size=vertices.shape)
    return torch.from_numpy(vertices).to(dtype or torch.float64), torch.from_numpy(faces)


def test_tensors_in_tensors_out() -> None:
    vertices, faces = mesh(torch.float32)
    light = nm.simplify((vertices, faces), ratio=0.5, effort="standard")
    v, f = light
    assert isinstance(v, torch.Tensor) and v.dtype == torch.float32 and isinstance(f, torch.Tensor)
    record = nm.record(vertices, faces, ratio=0.5)
    assert isinstance(record.faces, torch.Tensor)
    torch.testing.assert_close(record.positions(vertices), v, atol=1e-5, rtol=1e-5)


def test_opcheck() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    number = _records._record_number(record)
    for values in (vertices.clone().requires_grad_(), vertices, vertices.float()):
        torch.library.opcheck(_records._positions, (values, number, record.n_output))
    gradient = torch.randn(record.n_output, 3, dtype=torch.float64)
    torch.library.opcheck(_records._positions_backward, (vertices, gradient, number))


@pytest.mark.parametrize("size", [{"ratio": 0.4}, {"n_faces": 60}, {"ratio": 0.4, "optimize": "mean"}, {"ratio": 0.4, "subset": True}])
def test_gradcheck(size: dict[str, Any]) -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, **size)
    assert torch.autograd.gradcheck(record.positions, vertices.clone().requires_grad_(), eps=1e-7, atol=1e-4, rtol=1e-4)
    features = torch.randn(record.n_input, 5, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(record.pool, features)


def test_single_precision_gradients_match_double() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    weight = torch.randn(record.n_output, 3, dtype=torch.float64)
    gradients = []
    for dtype in (torch.float32, torch.float64):
        leaf = vertices.to(dtype).requires_grad_()
        (record.positions(leaf) * weight.to(dtype)).sum().backward()
        gradients.append(leaf.grad.double())
    torch.testing.assert_close(*gradients, atol=1e-3, rtol=1e-3)


def test_graph_keeps_record_alive() -> None:
    vertices, faces = mesh()
    leaf = vertices.clone().requires_grad_()
    loss = nm.record(vertices, faces, ratio=0.4).positions(leaf).square().sum()
    gc.collect()
    loss.backward()
    assert leaf.grad.abs().sum() > 0


def test_compiled() -> None:
    vertices, faces = mesh()
    records = [nm.record(vertices, faces, ratio=ratio) for ratio in (0.4, 0.5, 0.6)]

    def loss(record: Any, v: Any) -> Any:
        return record.positions(v).square().sum() + record.pool(v * 2).sum()

    compiled = torch.compile(loss, backend="aot_eager")
    for record in records:
        expected, result = vertices.clone().requires_grad_(), vertices.clone().requires_grad_()
        loss(record, expected).backward()
        compiled(record, result).backward()
        torch.testing.assert_close(result.grad, expected.grad)


def test_compiled_without_a_break() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    number, n = _records._record_number(record), record.n_output
    compiled = torch.compile(lambda v: _records._positions(v * 1.0, number, n).sum(), backend="aot_eager", fullgraph=True)
    leaf = vertices.clone().requires_grad_()
    compiled(leaf).backward()
    expected = vertices.clone().requires_grad_()
    record.positions(expected).sum().backward()
    torch.testing.assert_close(leaf.grad, expected.grad)


def test_batches_are_lists() -> None:
    meshes = [mesh(), mesh(n=16)]
    records = nm.record([v for v, _ in meshes], [f for _, f in meshes], ratio=0.5)
    outputs = nmt.positions(records, [v for v, _ in meshes])
    assert [len(v) for v in outputs] == [record.n_output for record in records]
    pooled = nmt.pool(records, [v for v, _ in meshes])
    assert [len(x) for x in pooled] == [len(v) for v in outputs]


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_in_workers_of_a_loader(context: str) -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    expected = [record.positions(vertices * (1 + at)) for at in range(4)]
    loader = torch.utils.data.DataLoader(Positions(record, vertices), num_workers=2, batch_size=None, multiprocessing_context=context)
    for result, other in zip(loader, expected, strict=True):
        torch.testing.assert_close(result, other)


class Positions(torch.utils.data.Dataset):  # type: ignore[misc]
    def __init__(self, record: nm.Record, vertices: Any) -> None:
        self.record, self.vertices = record, vertices

    def __len__(self) -> int:
        return 4

    def __getitem__(self, at: int) -> Any:
        return self.record.positions(self.vertices * (1 + at))


def test_records_are_pickled() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    record.positions(vertices)
    again = pickle.loads(pickle.dumps(record))
    torch.testing.assert_close(again.positions(vertices), record.positions(vertices))


def test_optimization_through_result() -> None:
    vertices, faces = mesh(n=20, m=12)
    record = nm.record(vertices, faces, ratio=0.3)
    goal = record.positions(vertices) * torch.tensor([1.0, 1.3, 0.8], dtype=torch.float64)
    leaf = vertices.clone().requires_grad_()
    optimizer = torch.optim.Adam([leaf], lr=0.01)
    losses = []
    for _ in range(60):
        optimizer.zero_grad()
        loss = (record.positions(leaf) - goal).square().mean()
        loss.backward()
        optimizer.step()
        losses.append(float(loss))
    assert losses[-1] < 0.05 * losses[0]


def test_wrong_shapes_are_rejected() -> None:
    vertices, faces = mesh()
    record = nm.record(vertices, faces, ratio=0.4)
    with pytest.raises(nm.NeuralMeshError, match="give 120 x 3"):
        record.positions(vertices[:5])


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU")
def test_gpu_tensors_are_copied_with_warning() -> None:
    vertices, faces = (tensor.cuda() for tensor in mesh())
    _arrays._HAS_WARNED = False
    record = nm.record(vertices, faces, ratio=0.4)
    leaf = vertices.clone().requires_grad_()
    with pytest.warns(UserWarning, match="copied from cuda"):
        result = record.positions(leaf)
    assert result.device.type == "cuda"
    result.sum().backward()
    assert leaf.grad.device.type == "cuda"

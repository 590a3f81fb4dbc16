"""The layer of PyTorch: the library's values and gradients, the paper's equations, batches, compilers, files, and errors."""

from __future__ import annotations

import copy
import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch as nmt  # noqa: E402
from conftest import MESHES, grid, torus  # noqa: E402
from neural_mesh import _native  # noqa: E402

GOLDEN = Path(__file__).resolve().parents[2] / "tests" / "golden"
WEIGHTS = GOLDEN.parents[1] / "crates/network/weights"


def read(path: Path) -> dict[str, Any]:
    """Reads the tensors of a safetensors file; whole numbers become int64, pairs of them `[2, n]`."""
    data = path.read_bytes()
    start = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:start])
    types = {"F32": np.float32, "I32": np.int32}
    tensors = {}
    for name, entry in header.items():
        if name != "__metadata__":
            values = np.frombuffer(data[start:][slice(*entry["data_offsets"])], types[entry["dtype"]])
            tensors[name] = torch.from_numpy(values.reshape(entry["shape"]).copy())
    return {name: x if x.is_floating_point() else x.long() for name, x in tensors.items()}


def assert_close(found: Any, expected: Any, share: float = 1e-5) -> None:
    """Asserts that tensors agree up to a share of the largest number, as small numbers may be rounding errors."""
    expected = expected.detach().reshape(found.shape).to(found.dtype)
    scale = float(expected.abs().max()) if expected.numel() else 0.0
    torch.testing.assert_close(found.detach(), expected, atol=share * scale + 1e-6, rtol=0)


def tensors(mesh: Any, dtype: Any = None) -> tuple[Any, Any]:
    vertices, faces = mesh
    return torch.from_numpy(np.ascontiguousarray(vertices)).to(dtype or torch.float32), torch.from_numpy(np.asarray(faces, np.int64))


def noisy(mesh: Any, scale: float, seed: int) -> Any:
    vertices, faces = mesh
    return vertices + np.random.default_rng(seed).normal(scale=scale, size=vertices.shape).astype(np.float32), faces


def read_ply(name: str) -> Any:
    light = nm.simplify(MESHES / name, ratio=1.0, weld=True)
    return np.asarray(light.vertices, np.float32), np.asarray(light.faces)


def two_tori() -> Any:
    (a, b), (c, d) = torus(20, 14), torus(12, 30)
    return np.concatenate([a, c + 3]), np.concatenate([b, d + len(a)])


# Scans, models, closed and open generated meshes, even and noisy, one of two components. Exact symmetry would leave vertices at equal
# distances from two samples, where rounding decides.
TEN_MESHES = {
    "spot": lambda: read_ply("spot.ply"),
    "suzanne": lambda: read_ply("suzanne.ply"),
    "nefertiti": lambda: read_ply("nefertiti.ply"),
    "torus": lambda: noisy(torus(40, 30), 1e-4, 3),
    "fine torus": lambda: noisy(torus(70, 60), 1e-4, 4),
    "thin torus": lambda: torus(150, 6),
    "rough torus": lambda: noisy(torus(40, 30), 0.01, 1),
    "very rough torus": lambda: noisy(torus(30, 30), 0.03, 2),
    "square": lambda: grid(25)[:2],
    "two components": two_tori,
}


@pytest.fixture(scope="module")
def golden() -> dict[str, Any]:
    return read(GOLDEN / "passes.safetensors")


@pytest.fixture(scope="module")
def equations() -> dict[str, Any]:
    return {name: x.double() if x.is_floating_point() else x for name, x in read(GOLDEN / "equations.safetensors").items()}


@pytest.fixture(scope="module")
def layer() -> Any:
    return nmt.Simplifier.from_weights("paper-open")


# Against the paper's equations, which tests/golden/equations.py computes pair by pair.


def both_ways(edges: Any, n: int) -> Any:
    return nmt._segments.entries_of(torch.cat([edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]]), n)


def with_values(module: Any, **values: Any) -> Any:
    """Sets parameters from the transposed weights of the equations, which multiply columns."""
    module = module.double()
    for name, value in values.items():
        place, last = module.get_submodule(name.rpartition(".")[0]), name.rpartition(".")[2]
        setattr(place, last, torch.nn.Parameter(value.T.clone() if value.dim() == 2 else value.reshape(1, -1).clone()))
    return module


def test_equations(equations: dict[str, Any]) -> None:
    e, x = equations, equations["x"].clone().requires_grad_()
    n = len(x)
    rings = both_ways(e["edges"], n)
    first = with_values(nmt.DevConv(3, 8), theta=e["theta_0"], phi=e["phi_0"])
    second = with_values(nmt.DevConv(8, 8), theta=e["theta_1"], phi=e["phi_1"])
    f_0 = first(x, rings)
    f_1 = second(f_0, rings)
    assert_close(f_0, e["f_0"])
    assert_close(f_1, e["f_1"])
    attention = with_values(nmt.SparseAttention(8, 6), query=e["query"], key=e["key"])
    extended = e["extended"].T
    s = attention(f_1, extended)
    assert_close(s, e["s"])
    edges = nmt.extended_graph(x, both_ways(e["a_edges"], n), 4)
    assert torch.equal(edges[:, edges[0] != edges[1]], extended)
    product = nmt._graphs.product_terms(extended, both_ways(e["a_edges"], n), n)
    slots = s.new_zeros(len(product.slots)).index_add(0, product.parts[1], s[product.parts[0]])
    a_s = torch.zeros_like(s).index_add(0, product.terms[0], slots[product.terms[1]] * s[product.terms[2]])[product.mirror]
    assert_close(a_s, e["a_s"])
    candidates = nmt.candidate_faces(extended, a_s)
    assert torch.equal(candidates.faces, e["candidates"])
    prior = a_s[candidates.entries].mean(1)
    assert_close(prior, e["prior"])
    positions = nmt.triangle_positions(x, candidates.faces)
    around = e["around"]
    graph = torch.stack([torch.arange(len(around))[:, None].expand_as(around).reshape(-1), around.reshape(-1)])
    assert_close(positions[graph[0]] - positions[graph[1]], e["r"])
    assert torch.equal(nmt.triangle_graph(x, candidates.faces, around.shape[1])[1], around.sort(1).values.reshape(-1))
    names = ("hidden.weights", "hidden.bias", "output.weights", "output.bias")
    convs = [
        with_values(nmt.TriConv(n_in, 7), **dict(zip(names, (e[name] for name in tensors), strict=True)))
        for n_in, tensors in ((1, ("w1", "b1", "w2", "b2")), (7, ("w3", "b3", "w4", "b4")))
    ]
    g_0 = convs[0](positions, prior[:, None], graph)
    g_1 = convs[1](positions, g_0, graph)
    assert_close(g_0, e["g_0"])
    assert_close(g_1, e["g_1"])
    slopes = torch.autograd.grad((g_1 * e["loss_weights"]).sum(), [x, first.theta, convs[0].hidden.weights])
    for found, expected in zip(slopes, (e["slope_x"], e["slope_theta_0"].T, e["slope_w1"].T), strict=True):
        assert_close(found, expected, 1e-4)


# Against the library.


def golden_layer(golden: dict[str, Any]) -> Any:
    layer = nmt.Simplifier(nmt.PointSampler(6, 2, 8, 4), nmt.EdgePredictor(8, 6, 6), nmt.FaceClassifier(2, 8, 5))
    layer.load_state_dict({name[len("weights.") :]: x for name, x in golden.items() if name.startswith("weights.")})
    return layer


def assert_gradients(golden: dict[str, Any], stage: Any, name: str, **inputs: Any) -> None:
    for tensor, leaf in stage.named_parameters():
        assert_close(leaf.grad, golden[f"gradient.{name}.{tensor}"])
    for tensor, leaf in inputs.items():
        # Equal edges of the golden mesh tie in the extremes of Eqs. (1) and (4); any of their slopes is right.
        expected = golden[f"gradient.{name}.{tensor}"].reshape(leaf.shape)
        assert torch.isclose(leaf.grad, expected, rtol=0, atol=1e-5 * float(expected.abs().max()) + 1e-6).float().mean() > 0.9


def outer(n: int) -> Any:
    """Returns output gradients equal to those of `tests/passes.rs`."""
    return (5 * torch.arange(n) % 11 - 5).float()


def test_gradients_match_library(golden: dict[str, Any]) -> None:
    layer, edges, graph = golden_layer(golden), golden["edges"].T, golden["graph"].T
    points, normals, prior = (golden[name].reshape(golden[name].shape if n else -1).requires_grad_() for name, n in (("points", 1), ("normals", 1), ("prior", 0)))
    scores = layer.point_sampler(points, edges, normals)
    assert_close(scores, golden["scores"])
    scores.backward(outer(len(scores)))
    assert_gradients(golden, layer.point_sampler, "point_sampler", points=points, normals=normals)
    points.grad = None
    found, product = layer.edge_predictor.extend(points, edges)
    assert torch.equal(found, graph)
    predicted = layer.edge_predictor(points, graph, product)
    assert_close(predicted.attention, golden["attention"])
    assert_close(predicted.adjacency, golden["adjacency"])
    torch.autograd.backward([*predicted], outer(2 * graph.shape[1]).split(graph.shape[1]))
    assert_gradients(golden, layer.edge_predictor, "edge_predictor", points=points)
    points.grad = None
    assert torch.equal(layer.face_classifier.join(points, golden["faces"]), golden["triangle_graph"].T)
    probabilities = layer.face_classifier(points, golden["faces"], prior, golden["triangle_graph"].T)
    assert_close(probabilities, golden["probabilities"])
    probabilities.backward(outer(len(prior)))
    assert_gradients(golden, layer.face_classifier, "face_classifier", points=points, prior=prior)


def test_inputs_of_stages_match_library(golden: dict[str, Any]) -> None:
    vertices, mesh = golden["vertices"], golden["mesh"]
    graph = nmt.mesh_graph(mesh, len(vertices))
    assert torch.equal(graph, golden["edges"].T)
    assert_close(nmt.vertex_normals(vertices, mesh), golden["normals"])
    assert_close(nmt.in_edge_lengths(vertices, graph), golden["points"])
    candidates = nmt.candidate_faces(golden["graph"].T, golden["adjacency"].reshape(-1))
    order = keys_of(golden["faces"]).argsort()
    assert torch.equal(candidates.faces, golden["faces"][order]) and torch.equal(candidates.entries, golden["entries"][order])
    assert_close(golden["adjacency"].reshape(-1)[candidates.entries].mean(1), golden["prior"][order])


@pytest.mark.parametrize("name", TEN_MESHES)
def test_stages_match_library(name: str, layer: Any) -> None:
    v, f = tensors(TEN_MESHES[name]())
    double = copy.deepcopy(layer).edge_predictor.double()
    weights = (WEIGHTS / "paper-open.safetensors").read_bytes()
    for ratio in (0.05, 0.3):
        theirs = _native.paper_stages(v.numpy(), f.numpy(), max(int(ratio * len(v)), 4), weights, 1, None)
        theirs = {name: torch.from_numpy(array) for name, array in theirs.items()}
        with torch.no_grad():
            ours = layer(v, f, samples=theirs["samples"])
            _, product = layer.edge_predictor.extend(ours.candidates.points, ours.candidates.between.edges)
            exact = double(ours.candidates.points.double(), ours.candidates.graph, product)
        mine = ours.candidates
        torch.testing.assert_close(ours.scores, theirs["scores"], atol=1e-5, rtol=1e-5)
        assert torch.equal(ours.regions, theirs["assignment"].long())
        assert torch.equal(mine.between.triangles, theirs["surface"].long())
        assert torch.equal(mine.graph, theirs["graph"].long().T)
        # Keys are up to 180 long, so that single precision leaves the library's attention an error of up to 1e-4 at few entries.
        for found, expected, true in zip(mine.edges, (theirs["attention"], theirs["adjacency"]), exact, strict=True):
            torch.testing.assert_close(found.double(), true, atol=1e-5, rtol=0)
            torch.testing.assert_close(found, expected, atol=2e-4, rtol=0)
            assert ((found - expected).abs() > 1e-5).float().mean() < 0.02
        # Candidates at the cut, of equal prior but for rounding, may differ, and change what their neighbours get.
        both = torch.isin(keys_of(mine.faces), keys_of(theirs["candidates"]))
        assert both.float().mean() > 0.99
        order = keys_of(theirs["candidates"]).argsort()
        with torch.no_grad():
            judged = theirs["candidates"].long()[order]
            p = layer.face_classifier(mine.points, judged, theirs["prior"][order], layer.face_classifier.join(mine.points, judged))
        off = (p - theirs["probabilities"][order]).abs()
        assert off.max() < 2e-5 and (off > 1e-5).float().mean() < 1e-4
        found, expected = keys_of(rotated(ours.samples[ours.faces])), keys_of(rotated(theirs["faces"].long()))
        assert len(expected) > 0
        assert torch.isin(expected, found).float().mean() >= 0.999 and torch.isin(found, expected).float().mean() >= 0.999


def keys_of(faces: Any) -> Any:
    faces = faces.long()
    return (faces[:, 0] << 42) + (faces[:, 1] << 21) + faces[:, 2]


def rotated(faces: Any) -> Any:
    """Turns each face until its least vertex is first, which keeps its winding."""
    at = faces.argmin(1, keepdim=True)
    return faces.gather(1, (at + torch.arange(3)) % 3)


# The draws.


def spread(points: Any, samples: Any) -> Any:
    return torch.cdist(points, points[samples]).amin(1).square().mean()


def sphere(level: int) -> tuple[Any, Any]:
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(level)
    return tensors((np.asarray(ball.vertices), np.asarray(ball.faces)))


def drawn(name: str, v: Any, f: Any, scores: Any, k: int, seed: int) -> Any:
    batch, counts = torch.zeros(len(v), dtype=torch.int64), torch.tensor([k])
    sampling = nmt._sampling
    if name == "multinomial":
        return sampling.multinomial_samples(scores, counts, batch, torch.tensor([seed]))
    graph = nmt.mesh_graph(f, len(v))
    return sampling.scattered_samples(nmt.in_edge_lengths(v, graph), graph, scores, counts, batch, torch.tensor([seed]))


def test_scattered_samples_cover_and_follow_the_scores() -> None:
    v, f = sphere(4)
    even = torch.zeros(len(v))
    for k in (30, 200):
        kinds = [drawn(name, v, f, even, k, 1) for name in ("scattered", "multinomial")]
        assert [len(samples) for samples in kinds] == [k, k]
        assert spread(v, kinds[0]) < 0.7 * spread(v, kinds[1])
    more = torch.where(v[:, 2] > 0, np.log(4.0), 0.0)
    above = float((v[drawn("scattered", v, f, more, 300, 3)][:, 2] > 0).sum())
    assert abs(above / (300 - above) / 4 - 1) < 0.3
    for k in (1, 50, len(v) - 1, len(v)):
        samples = drawn("scattered", v, f, even, k, 5)
        assert len(samples) == k and bool((samples[1:] > samples[:-1]).all())


def test_every_component_gets_a_sample() -> None:
    v, f = tensors(torus(8, 6))
    many, faces = torch.cat([v * (1 + 9 * (i % 2)) + 40 * i for i in range(10)]), torch.cat([f + len(v) * i for i in range(10)])
    samples = drawn("scattered", many, faces, torch.zeros(len(many)), 30, 2)
    assert len(torch.unique(samples // len(v))) == 10


def test_multinomial_follows_the_softmax() -> None:
    scores, n = torch.tensor([0.0, 1.0, 2.0]), 20_000
    place = torch.arange(3).repeat(n)
    sampling = nmt._sampling
    batch = torch.arange(n).repeat_interleave(3)
    first = place[sampling.multinomial_samples(scores.repeat(n), torch.ones(n, dtype=torch.int64), batch, torch.arange(n))]
    assert (torch.bincount(first, minlength=3) / n - scores.softmax(0)).abs().max() < 0.015


def test_inclusion() -> None:
    torch.testing.assert_close(nmt.inclusion(torch.full((4,), 3.0), 1), torch.full((4,), 0.25))
    torch.testing.assert_close(nmt.inclusion(torch.tensor([0.0, 200.0, -50.0, 200.0]), 2), torch.tensor([0.0, 1.0, 0.0, 1.0]))
    torch.testing.assert_close(nmt.inclusion(torch.tensor([0.0, 1.0]), 2), torch.ones(2))
    scores = torch.randn(12, dtype=torch.float64, generator=torch.Generator().manual_seed(1)).requires_grad_()
    batch, counts = torch.tensor([0] * 7 + [1] * 5), torch.tensor([3, 2])
    chances = nmt.inclusion(scores, counts, batch)
    torch.testing.assert_close(torch.stack([chances[:7].sum(), chances[7:].sum()]), counts.double())
    torch.testing.assert_close(chances[:7], nmt.inclusion(scores[:7], 3))
    assert torch.autograd.gradcheck(lambda s: nmt.inclusion(s, counts, batch), scores)
    assert torch.autograd.gradgradcheck(lambda s: nmt.inclusion(s, counts, batch), scores)


@pytest.mark.parametrize("gradient", ["straight-through", "score"])
def test_gradients_through_the_draw_move_samples(gradient: str) -> None:
    """Scores learn to keep the upper half, from a loss that only sees which vertices were drawn."""
    v, f = tensors(torus(16, 10))
    scores = torch.zeros(len(v), requires_grad=True)
    optimizer, batch, counts = torch.optim.Adam([scores], lr=0.1), torch.zeros(len(v), dtype=torch.int64), torch.tensor([30])
    first = baseline = None
    for step in range(60):
        chances = nmt.inclusion(scores, counts)
        samples = drawn("multinomial", v, f, scores, 30, step)
        lost = (v[samples, 2] < 0).float()
        if gradient == "straight-through":
            loss = (lost * chances[samples] / chances[samples].detach()).mean()
        else:
            baseline = lost.mean() if baseline is None else 0.9 * baseline + 0.1 * lost.mean()
            chance = nmt._sampling.log_probability(chances, samples, batch, 1)
            loss = nmt.losses.score_function(lost.mean()[None], chance, baseline)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        first = lost.mean() if first is None else first
    assert lost.mean() < 0.6 * first


def test_surface_losses_reach_the_sampler() -> None:
    v, f = tensors(torus(24, 16))
    for gradient, reaches in (("straight-through", True), ("none", False)):
        layer = nmt.Simplifier.from_weights("paper-open", gradient=gradient)
        layer(v, f, 0.2, seed=1).probabilities.sum().backward()
        found = layer.point_sampler.score.weights.grad
        assert (found is not None and bool(found.abs().sum() > 0)) == reaches


# Results and batches.


def edge_counts(faces: Any) -> Any:
    edges = torch.cat([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return torch.unique(edges.sort(1).values, dim=0, return_counts=True)[1]


def test_result(layer: Any) -> None:
    v, f = tensors(torus(60, 40))
    v.requires_grad_()
    result = layer(v, f, ratio=0.1, seed=1)
    n = len(result.samples)
    assert n == 240 and torch.equal(result.vertices, v[result.samples]) and result.probabilities.shape == (len(result.faces),)
    counts = edge_counts(result.faces)
    assert bool((counts <= 2).all()) and (counts == 2).float().mean() > 0.95
    assert bool((result.probabilities > 0.5).all())
    # Wound like the input: the enclosed volumes agree.
    volumes = [float(torch.linalg.det(x.detach()[t]).sum() / 6) for x, t in ((v, f), (result.vertices, result.faces))]
    assert 0.7 < volumes[1] / volumes[0] < 1.05
    assert result.pool.shape == (n, len(v)) and result.unpool.shape == (len(v), n)
    ones = torch.ones(len(v), 1)
    torch.testing.assert_close(result.pool @ ones, torch.ones(n, 1))
    torch.testing.assert_close(result.unpool @ ones[:n], ones)
    torch.testing.assert_close(result.pool @ (result.unpool @ result.vertices), result.vertices)
    assert (result.pool @ v - result.vertices).norm(dim=1).mean() < 0.1
    (result.vertices.square().sum() + (result.pool @ v).sum() + result.candidates.probabilities.sum()).backward()
    assert v.grad.isfinite().all() and all(p.grad is not None for p in layer.parameters())
    layer.zero_grad()
    assert len(layer(v, f, n_samples=50).samples) == 50
    torch.manual_seed(3)
    one = layer(v, f, 0.1).samples
    torch.manual_seed(3)
    assert torch.equal(layer(v, f, 0.1).samples, one) and not torch.equal(layer(v, f, 0.1).samples, one)


@pytest.mark.parametrize("draw", ["scattered", "multinomial"])
def test_packed_equals_single(draw: str) -> None:
    layer = nmt.Simplifier.from_weights("paper-open", draw=draw)
    meshes = [tensors(mesh) for mesh in (torus(24, 16), noisy(torus(30, 20), 0.01, 1), grid(20)[:2])]
    vertices, faces = [list(x) for x in zip(*meshes, strict=True)]
    alone = [layer(v, f, 0.2, seed=7 + i) for i, (v, f) in enumerate(meshes)]
    sizes = torch.tensor([len(v) for v in vertices])
    starts = sizes.cumsum(0) - sizes
    packed = torch.cat(vertices), torch.cat([f + start for f, start in zip(faces, starts, strict=True)])
    for result in (layer(vertices, faces, 0.2, seed=7), layer(*packed, 0.2, torch.arange(3).repeat_interleave(sizes), seed=7)):
        torch.testing.assert_close(result.scores, torch.cat([one.scores for one in alone]))
        assert torch.equal(result.samples, torch.cat([one.samples + start for one, start in zip(alone, starts, strict=True)]))
        torch.testing.assert_close(result.log_probability, torch.cat([one.log_probability for one in alone]), rtol=1e-4, atol=1e-2)
        for (v, f), one in zip(result.unpack(), alone, strict=True):
            assert torch.equal(v, one.vertices)
            assert torch.isin(keys_of(f), keys_of(one.faces)).float().mean() >= 0.999 and abs(len(f) - len(one.faces)) <= 1
        torch.testing.assert_close(result.pool @ packed[0], torch.cat([one.pool @ v for one, v in zip(alone, vertices, strict=True)]))


def test_one_connectivity(layer: Any) -> None:
    v, f = tensors(torus(20, 16))
    several = torch.stack([v, 2 * v + 1, v.flip(1)])
    result = layer(several, f, 0.25, seed=4)
    assert torch.equal(torch.bincount(result.batch), torch.tensor([80, 80, 80]))
    assert result.vertices.view(3, 80, 3).shape == (3, 80, 3) and len(result.unpack()) == 3
    first = layer(v, f, 0.25, seed=4)
    assert torch.equal(result.unpack()[0][0], first.vertices) and len(result.unpack()[0][1]) == len(first.faces)


# What PyTorch does with modules.


def stage_inputs(layer: Any, mesh: Any = None, dtype: Any = None) -> list[tuple[Any, tuple[Any, ...]]]:
    v, f = tensors(noisy(torus(14, 10), 0.02, 2) if mesh is None else mesh, dtype)
    graph = nmt.mesh_graph(f, len(v))
    points = nmt.in_edge_lengths(v, graph)
    extended, product = layer.edge_predictor.extend(points, graph)
    with torch.no_grad():
        edges = layer.edge_predictor(points, extended, product)
    faces, entries = nmt.candidate_faces(extended, edges.adjacency, None, 6, None, len(v))
    prior = edges.adjacency[entries].mean(1)
    normals = (nmt.vertex_normals(v, f),) if layer.point_sampler.sizes["point_sampler_inputs"] == 6 else ()
    return [
        (layer.point_sampler, (points, graph, *normals)),
        (layer.edge_predictor, (points, extended, product)),
        (layer.face_classifier, (points, faces, prior, layer.face_classifier.join(points, faces))),
    ]


def flat(outputs: Any) -> Any:
    return outputs if isinstance(outputs, torch.Tensor) else torch.cat(outputs)


@pytest.mark.parametrize("stage", range(3))
def test_export(layer: Any, stage: int) -> None:
    module, inputs = stage_inputs(layer)[stage]
    program = torch.export.export(module, inputs, strict=False)
    assert_close(flat(program.module()(*inputs)), flat(module(*inputs)))
    # With sizes left open, the program runs on another mesh.
    dynamic = torch.utils._pytree.tree_map(lambda x: {i: torch.export.Dim.AUTO for i, n in enumerate(x.shape) if n > 9}, inputs)
    program = torch.export.export(module, inputs, dynamic_shapes=dynamic, strict=False)
    _, others = stage_inputs(layer, torus(18, 12))[stage]
    assert_close(flat(program.module()(*others)), flat(module(*others)))


@pytest.mark.parametrize("stage", range(3))
def test_compiled_as_one_graph(layer: Any, stage: int) -> None:
    module, inputs = stage_inputs(copy.deepcopy(layer))[stage]
    expected = flat(module(*inputs))
    slopes = torch.autograd.grad(expected.square().sum(), list(module.parameters()), allow_unused=True)
    compiled = torch.compile(module, fullgraph=True, backend="aot_eager")
    found = flat(compiled(*inputs))
    assert_close(found, expected)
    for slope, other in zip(torch.autograd.grad(found.square().sum(), list(module.parameters()), allow_unused=True), slopes, strict=True):
        assert (slope is None) == (other is None)
        if slope is not None:
            assert_close(slope, other, 1e-4)


def test_autocast(layer: Any) -> None:
    v, f = tensors(torus(30, 20))
    with torch.no_grad():
        exact = layer(v, f, 0.2, seed=1)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            result = layer(v, f, samples=exact.samples)
            for module, inputs in stage_inputs(layer):
                assert flat(module(*inputs)).isfinite().all()
    assert (result.scores - exact.scores).abs().max() < 0.1 * exact.scores.abs().max()
    assert torch.isin(keys_of(result.faces), keys_of(exact.faces)).float().mean() > 0.8
    with torch.autocast("cpu", dtype=torch.bfloat16):
        layer(v, f, 0.2, seed=1).candidates.probabilities.mean().backward()
    assert all(p.grad is not None and p.grad.isfinite().all() for p in layer.parameters())
    layer.zero_grad()


def small_layer(inputs: int = 6) -> Any:
    sizes = nmt.PointSampler(inputs, 2, 4, 3, seed=1), nmt.EdgePredictor(4, 3, 4, seed=1), nmt.FaceClassifier(2, 4, 0, seed=1)
    return nmt.Simplifier(*sizes).double()


@pytest.mark.parametrize("stage", range(3))
def test_gradcheck(stage: int) -> None:
    module, inputs = stage_inputs(small_layer(), noisy(torus(4, 3), 0.05, 5), torch.float64)[stage]
    leaves = [x.clone().requires_grad_() if isinstance(x, torch.Tensor) and x.is_floating_point() else x for x in inputs]
    if stage == 2:
        leaves[1], leaves[2] = leaves[1][:12], inputs[2][:12].clone().requires_grad_()
        leaves[3] = module.join(inputs[0], leaves[1])
    names = [name for name, _ in module.named_parameters()]

    def run(*given: Any) -> Any:
        state = dict(zip(names, given, strict=False))
        values = iter(given[len(names) :])
        arguments = [next(values) if isinstance(x, torch.Tensor) and x.is_floating_point() else x for x in leaves]
        return flat(torch.func.functional_call(module, state, tuple(arguments)))

    given = [p.detach().clone().requires_grad_() for p in module.parameters()]
    given += [x for x in leaves if isinstance(x, torch.Tensor) and x.is_floating_point()]
    assert torch.autograd.gradcheck(run, given, eps=1e-7, atol=1e-5, fast_mode=True)
    assert torch.autograd.gradgradcheck(run, given, eps=1e-7, atol=1e-4, fast_mode=True)


def test_precisions_and_copies(layer: Any) -> None:
    v, f = tensors(torus(24, 16))
    expected = layer(v, f, 0.2, seed=1)
    for other in (copy.deepcopy(layer), pickle.loads(pickle.dumps(layer))):
        assert torch.equal(other(v, f, 0.2, seed=1).faces, expected.faces)
    double = copy.deepcopy(layer).double()(v.double(), f.int(), 0.2, seed=1)
    assert double.vertices.dtype == double.probabilities.dtype == torch.float64
    assert torch.isin(double.samples, expected.samples).float().mean() > 0.9
    half = layer(v.half(), f, 0.2, seed=1)
    assert half.vertices.dtype == torch.float16 and len(half.faces) > 0


def train_in_process(rank: int, folder: str) -> None:
    torch.distributed.init_process_group("gloo", init_method=f"file://{folder}/store", rank=rank, world_size=2)
    torch.manual_seed(0)
    layer = torch.nn.parallel.DistributedDataParallel(small_layer().float())
    optimizer = torch.optim.SGD(layer.parameters(), lr=0.1)
    for step in range(2):
        v, f = tensors(torus(16 + 4 * rank, 12))
        result = layer(v, f, 0.3, seed=step)
        terms = nmt.losses.objective_terms(result, v, f)
        optimizer.zero_grad()
        nmt.losses.total(terms).backward()
        optimizer.step()
    torch.save(layer.module.state_dict(), f"{folder}/{rank}.pt")
    torch.distributed.destroy_process_group()


def test_distributed(tmp_path: Path) -> None:
    torch.multiprocessing.spawn(train_in_process, (str(tmp_path),), nprocs=2)
    states = [torch.load(tmp_path / f"{rank}.pt") for rank in range(2)]
    start = small_layer().float().state_dict()
    assert all(torch.equal(states[0][name], states[1][name]) for name in start)
    assert any(not torch.equal(states[0][name], start[name]) for name in start)


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_in_workers_of_a_loader(context: str) -> None:
    data = Results()
    expected = [data[at] for at in range(4)]
    loader = torch.utils.data.DataLoader(data, num_workers=2, batch_size=None, multiprocessing_context=context)
    assert all(torch.equal(a, b) for a, b in zip(loader, expected, strict=True))


class Results(torch.utils.data.Dataset):  # type: ignore[misc]
    def __init__(self) -> None:
        self.layer, self.mesh = nmt.Simplifier.from_weights(), tensors(torus(20, 16))

    def __len__(self) -> int:
        return 4

    def __getitem__(self, at: int) -> Any:
        with torch.no_grad():
            return self.layer(*self.mesh, 0.3, seed=at).samples


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU")
def test_on_a_gpu(layer: Any) -> None:
    v, f = tensors(torus(60, 40))
    on_gpu = copy.deepcopy(layer).cuda()
    expected, result = layer(v, f, 0.1, seed=1), on_gpu(v.cuda(), f.cuda(), 0.1, seed=1)
    assert result.vertices.device.type == result.pool.device.type == "cuda"
    same = layer(v, f, samples=result.samples.cpu())
    torch.testing.assert_close(result.scores.cpu(), expected.scores, atol=1e-4, rtol=1e-4)
    assert torch.isin(keys_of(result.faces.cpu()), keys_of(same.faces)).float().mean() > 0.999
    result.candidates.probabilities.sum().backward()
    assert all(p.grad.device.type == "cuda" for p in on_gpu.parameters())


# Files and errors.


def test_weights_files(tmp_path: Path) -> None:
    for name in ("default", "paper-open"):
        layer = nmt.Simplifier.from_weights(name)
        layer.save(tmp_path / "weights.safetensors")
        tensors, state = read(tmp_path / "weights.safetensors"), layer.state_dict()
        assert tensors.keys() == state.keys() and all(torch.equal(tensors[key], state[key]) for key in tensors)
        again = nmt.Simplifier.from_weights(WEIGHTS / f"{name}.safetensors")
        assert again.objective == layer.objective and str(again) == str(layer)
    assert (tmp_path / "weights.safetensors").read_bytes() == (WEIGHTS / "paper-open.safetensors").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["weights.safetensors"]
    assert sum(p.numel() for p in nmt.Simplifier().parameters()) == 14_658
    drawn = [nmt.PointSampler(seed=seed).score.weights for seed in (3, 3, 4)]
    assert torch.equal(drawn[0], drawn[1]) and not torch.equal(drawn[0], drawn[2])


def test_other_sizes_and_inputs() -> None:
    """Normals as input, and G_tri of the nearest barycenters, alone and in a batch."""
    meshes = [tensors(torus(24, 16)), tensors(torus(20, 14))]
    for layer in (nmt.Simplifier.from_weights("default"), nmt.Simplifier(nmt.PointSampler(6, 1, 8, 4), None, nmt.FaceClassifier(2, 8, 7, candidates=0))):
        vertices, faces = [list(x) for x in zip(*meshes, strict=True)]
        packed = layer(vertices, faces, 0.3, seed=1)
        alone = [layer(v, f, 0.3, seed=1 + i) for i, (v, f) in enumerate(meshes)]
        torch.testing.assert_close(packed.scores, torch.cat([one.scores for one in alone]))
        assert len(packed.samples) == sum(len(one.samples) for one in alone)
        found = packed.candidates.probabilities.sum()
        torch.testing.assert_close(found, sum(one.candidates.probabilities.sum() for one in alone), rtol=1e-3, atol=0.1)
        found.backward()


def test_saved_weights_work_in_the_library(tmp_path: Path) -> None:
    layer = nmt.Simplifier.from_weights("paper-open")
    with torch.no_grad():
        layer.face_classifier.output.bias -= 4
    layer.save(tmp_path / "mine.safetensors")
    vertices, faces = torus(60, 50)
    ours = nm.simplify((vertices, faces), ratio=0.1, assembly="paper", weights=tmp_path / "mine.safetensors")
    assert 0 < len(ours.faces) < len(nm.simplify((vertices, faces), ratio=0.1, assembly="paper").faces)


def test_small_meshes(layer: Any) -> None:
    v, f = torch.tensor([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), torch.tensor([[0, 1, 2]])
    assert layer(v, f, 1.0).candidates.faces.tolist() == [[0, 1, 2]]
    for n in (1, 2):
        result = layer(v, f, n_samples=n)
        assert result.faces.shape == (0, 3) and len(result.samples) == n
        result.candidates.probabilities.sum().backward()
    spare = torch.cat([v, v + 5])
    assert layer(spare, f, n_samples=3, seed=0).samples.tolist() == [0, 1, 2]
    assert layer(v * 0, f, 1.0).scores.isfinite().all()


def test_errors(layer: Any, tmp_path: Path) -> None:
    v, f = tensors(torus(8, 6))
    nan = v.clone()
    nan[4, 1] = float("nan")
    wrong = [
        (r"vertices: .*\(48, 2\).*give n x 3", lambda: layer(v[:, :2], f, 0.5)),
        (r"vertices: .*int64.*floating", lambda: layer(v.long(), f, 0.5)),
        (r"vertices: .*not finite", lambda: layer(nan, f, 0.5)),
        (r"faces: .*give m x 3", lambda: layer(v, f.T, 0.5)),
        (r"faces: .*whole numbers", lambda: layer(v, f.float(), 0.5)),
        (r"faces: one names vertex 47, but there are 47", lambda: layer(v[:-1], f, 0.5)),
        (r"faces: one names vertex -1", lambda: layer(v, f - 1, 0.5)),
        (r"faces: there are none", lambda: layer(v, f[:0], 0.5)),
        (r"faces: give a list of as many as vertices \(2\)", lambda: layer([v, v], [f], 0.5)),
        (r"exactly one of ratio, n_samples and samples", lambda: layer(v, f)),
        (r"ratio: 0: give a share", lambda: layer(v, f, 0)),
        (r"samples: give vertices from 0 to 47", lambda: layer(v, f, samples=torch.tensor([48]))),
        (r"batch: a tensor of shape", lambda: layer(v, f, 0.5, torch.zeros(3, dtype=torch.int64))),
        (r"batch: .*ascending", lambda: layer(v, f, 0.5, torch.arange(48).flip(0))),
        (r"faces: a face joins vertices of two meshes", lambda: layer(v, f, 0.5, torch.arange(48) // 24)),
        (r"batch: .*leave it out", lambda: layer(v[None], f, 0.5, torch.zeros(48, dtype=torch.int64))),
        (r'draw: "darts": give "scattered"', lambda: nmt.Simplifier(draw="darts")),
        (r"sizes.*point_sampler_width=-1", lambda: nmt.PointSampler(width=-1)),
        (r"none.safetensors: No such file.*paper-open", lambda: nmt.Simplifier.from_weights(tmp_path / "none.safetensors")),
        (r"test_torch_layer.py: not a safetensors file", lambda: nmt.Simplifier.from_weights(__file__)),
        (r"nowhere.*: No such file", lambda: layer.save(tmp_path / "nowhere" / "w.safetensors")),
    ]  # fmt: skip
    for said, call in wrong:
        with pytest.raises(nm.NeuralMeshError, match=said) as raised:
            call()
        assert os.linesep not in str(raised.value)

"""PyTorch modules of the network: the library's values, gradients, the paper's equations, files, and errors."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch as nmt  # noqa: E402
from conftest import torus  # noqa: E402

GOLDEN = Path(__file__).resolve().parents[2] / "tests" / "golden" / "passes.safetensors"


def read(path: Path) -> dict[str, Any]:
    """Reads the tensors of a safetensors file."""
    data = path.read_bytes()
    start = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:start])
    types = {"F32": np.float32, "I32": np.int32}
    tensors = {name: entry for name, entry in header.items() if name != "__metadata__"}
    return {
        name: torch.from_numpy(
            np.frombuffer(data[start:][slice(*entry["data_offsets"])], types[entry["dtype"]]).reshape(entry["shape"]).copy()
        )
        for name, entry in tensors.items()
    }


def weights(n: int) -> Any:
    """Returns output gradients equal to those of `tests/passes.rs`."""
    return (5 * torch.arange(n) % 11 - 5).float()


def assert_close(found: Any, expected: Any, share: float = 1e-5) -> None:
    """Asserts that tensors agree up to a share of the largest number, as small numbers may be rounding errors."""
    expected = expected.detach().reshape(found.shape).to(found.dtype)
    scale = float(expected.abs().max()) if expected.numel() else 0.0
    torch.testing.assert_close(found.detach(), expected, atol=share * scale + 1e-6, rtol=0)


@pytest.fixture(scope="module")
def golden() -> dict[str, Any]:
    return read(GOLDEN)


def golden_stage(golden: dict[str, Any]) -> Any:
    network = nmt.Network(nmt.PointSampler(6, 2, 8, 4), nmt.EdgePredictor(8, 6, 6), nmt.FaceClassifier(2, 8, 5))
    network.load_state_dict({name[len("weights.") :]: x for name, x in golden.items() if name.startswith("weights.")})
    return network


def assert_gradients(golden: dict[str, Any], stage: Any, name: str, **inputs: Any) -> None:
    for tensor, parameter in stage.named_parameters():
        assert_close(parameter.grad, golden[f"gradient.{name}.{tensor}"])
    for tensor, leaf in inputs.items():
        assert_close(leaf.grad, golden[f"gradient.{name}.{tensor}"])


def test_point_sampler_matches_library(golden: dict[str, Any]) -> None:
    stage = golden_stage(golden).point_sampler
    points, normals = (golden[name].requires_grad_() for name in ("points", "normals"))
    scores = stage(points, golden["edges"], normals)
    assert scores.shape == (len(points),)
    assert_close(scores, golden["scores"])
    scores.backward(weights(len(scores)))
    assert_gradients(golden, stage, "point_sampler", points=points, normals=normals)


def test_edge_predictor_matches_library(golden: dict[str, Any]) -> None:
    stage = golden_stage(golden).edge_predictor
    points = golden["points"].detach().requires_grad_()
    edges = stage(points, golden["edges"])
    assert torch.equal(edges.graph, golden["graph"].long())
    assert_close(edges.attention, golden["attention"])
    assert_close(edges.adjacency, golden["adjacency"])
    torch.autograd.backward([edges.attention, edges.adjacency], weights(2 * len(edges.graph)).split(len(edges.graph)))
    assert_gradients(golden, stage, "edge_predictor", points=points)


def test_face_classifier_matches_library(golden: dict[str, Any]) -> None:
    stage = golden_stage(golden).face_classifier
    points, prior = golden["points"].detach().requires_grad_(), golden["prior"].reshape(-1).requires_grad_()
    probabilities = stage(points, golden["faces"], prior)
    assert_close(probabilities, golden["probabilities"])
    probabilities.backward(weights(len(prior)))
    assert_gradients(golden, stage, "face_classifier", points=points, prior=prior)
    assert torch.equal(nmt.triangle_graph(points, golden["faces"], 5), golden["triangle_graph"].long())


def test_stage_inputs_match_library(golden: dict[str, Any]) -> None:
    vertices, mesh = golden["vertices"], golden["mesh"]
    edges = nmt.edges_of_faces(mesh)
    assert torch.equal(edges, golden["edges"][golden["edges"][:, 0] < golden["edges"][:, 1]].long())
    assert_close(nmt.vertex_normals(vertices, mesh), golden["normals"])
    assert_close(nmt.in_edge_lengths(vertices, edges), golden["points"])
    candidates = nmt.candidate_faces(golden["points"], golden["graph"], golden["adjacency"].reshape(-1))
    assert torch.equal(candidates.faces, golden["faces"].long())
    assert torch.equal(candidates.entries, golden["entries"].long())
    assert_close(golden["adjacency"].reshape(-1)[candidates.entries].mean(1), golden["prior"])


# The equations of docs/paper.md, naively per node, in double precision.


def dev_conv(x: Any, rows: list[list[int]], layer: Any) -> Any:
    """Computes Eq. (1)."""
    largest = [((x[i] - x[js]) @ layer["theta"]).max(0).values for i, js in enumerate(rows)]
    return (torch.stack(largest) @ layer["phi"]).relu()


def affine(x: Any, layer: Any) -> Any:
    return x @ layer["weights"] + layer["bias"]


def tri_conv(x: Any, rows: list[list[int]], positions: Any, layer: Any) -> Any:
    """Computes Eqs. (4) and (5)."""
    seen = torch.cat([positions, x], 1)
    pairs = [affine(affine(seen[i] - seen[ks], layer["hidden"]).relu(), layer["output"]) for i, ks in enumerate(rows)]
    return torch.stack([pair.sum(0) for pair in pairs])


def rows_of(entries: Any, n: int) -> list[list[int]]:
    return [entries[entries[:, 0] == i, 1].tolist() for i in range(n)]


def tree(stage: Any) -> dict[str, Any]:
    """Returns the parameters in double precision, nested by the components of their names."""
    result: dict[str, Any] = {}
    for name, parameter in stage.named_parameters():
        *path, last = name.split(".")
        place = result
        for part in path:
            place = place.setdefault(part, {})
        place[last] = parameter.detach().double().requires_grad_()
    return result


def leaves(of: dict[str, Any]) -> list[Any]:
    return [leaf for part in of.values() for leaf in (leaves(part) if isinstance(part, dict) else [part])]


def naive_scores(of: Any, points: Any, normals: Any, rows: list[list[int]]) -> Any:
    x = points if len(of["dev_conv_0"]["theta"]) == 3 else torch.cat([points, normals], 1)
    for name in (name for name in of if name.startswith("dev_conv")):
        x = dev_conv(x, rows, of[name])
    return affine(affine(x, of["hidden"]).relu() if "hidden" in of else x, of["score"])[:, 0]


def naive_edges(of: Any, points: Any, rows: list[list[int]], original: list[list[int]]) -> tuple[Any, Any]:
    n = len(points)
    features = dev_conv(points, rows, of["dev_conv"])
    query, key = features @ of["attention"]["query"], features @ of["attention"]["key"]
    a, zeros = torch.zeros(n, n, dtype=torch.float64), torch.zeros(n, dtype=torch.float64)
    for i, js in enumerate(original):
        a[i, js] = 1.0
    closeness = [-0.5 * (query[i] - key[js]).square().sum(1) for i, js in enumerate(rows)]
    s = torch.stack([zeros.index_put((torch.tensor(js),), c.softmax(0)) for js, c in zip(rows, closeness, strict=True)])
    along = [torch.cat([m[i, js] for i, js in enumerate(rows)]) for m in (s, s @ a @ s.T)]
    return along[0], along[1]


def naive_probabilities(of: Any, points: Any, faces: Any, prior: Any, rows: list[list[int]]) -> Any:
    i, j, k = (points[faces[:, corner]] for corner in range(3))
    sides = torch.stack([i - j, i - k, j - k])
    positions = torch.cat([sides.min(0).values, sides.max(0).values, (i + j + k) / 3], 1)
    x = prior[:, None]
    for name in (name for name in of if name.startswith("tri_conv")):
        x = tri_conv(x, rows, positions, of[name])
    return affine(x, of["output"]).sigmoid()[:, 0]


def mesh() -> tuple[Any, Any, Any, Any]:
    """Returns points in edge lengths, edges, normals and faces."""
    vertices, faces = torus(9, 7, np.float64)
    vertices += np.random.default_rng(2).normal(scale=0.02, size=vertices.shape)
    points, corners = torch.from_numpy(vertices).float(), torch.from_numpy(faces)
    edges = nmt.edges_of_faces(corners)
    return nmt.in_edge_lengths(points, edges), edges, nmt.vertex_normals(points, corners), corners


@pytest.mark.parametrize("name", ["default", "paper-open", None])
def test_stages_match_equations(name: str | None) -> None:
    points, edges, normals, _ = mesh()
    both = torch.cat([edges, edges.flip(1)])
    network = nmt.Network() if name is None else nmt.Network.shipped(name)
    generator = torch.Generator().manual_seed(1)

    def check(stage: Any, found: Any, inputs: list[Any], expected: Any, of: Any, doubles: list[Any]) -> None:
        weight = torch.randn(found.shape, generator=generator)
        (found * weight).sum().backward()
        (expected * weight.double()).sum().backward()
        # The tolerance is for squared lengths from single-precision dot products in the library's attention.
        assert_close(found, expected, 1e-4)
        leaf_pairs = zip([*stage.parameters(), *inputs], [*leaves(of), *doubles], strict=True)
        for leaf, double in leaf_pairs:
            assert_close(leaf.grad, double.grad if double.grad is not None else torch.zeros_like(double), 1e-4)

    def pair(values: Any) -> tuple[Any, Any]:
        return values.detach().clone().requires_grad_(), values.detach().double().requires_grad_()

    (p, p2), (q, q2), of = pair(points), pair(normals), tree(network.point_sampler)
    expected = naive_scores(of, p2, q2, rows_of(both, len(points)))
    check(network.point_sampler, network.point_sampler(p, edges, q), [p, q], expected, of, [p2, q2])

    (p, p2), of = pair(points), tree(network.edge_predictor)
    predicted = network.edge_predictor(p, edges)
    expected = torch.cat(naive_edges(of, p2, rows_of(predicted.graph, len(points)), rows_of(both, len(points))))
    check(network.edge_predictor, torch.cat(predicted[1:]), [p], expected, of, [p2])

    candidates = nmt.candidate_faces(points, predicted.graph, predicted.adjacency)
    faces = candidates.faces[:200]
    (p, p2), (r, r2), of = pair(points), pair(predicted.adjacency[candidates.entries].mean(1)[:200]), tree(network.face_classifier)
    graph = nmt.triangle_graph(points, faces, 8)
    expected = naive_probabilities(of, p2, faces, r2, rows_of(graph, len(faces)))
    check(network.face_classifier, network.face_classifier(p, faces, r, graph), [p, r], expected, of, [p2, r2])


def assert_gradients_match_differences(function: Any, leaf: Any) -> None:
    """Asserts that most gradients match differences; kinks spoil a few of them, a wrong gradient spoils most."""
    (gradient,) = torch.autograd.grad(function(leaf), leaf)
    scale = float(gradient.abs().max())
    errors = []
    for at in range(min(leaf.numel(), 40)):
        step = torch.zeros(leaf.numel())
        step[at] = 5e-4
        with torch.no_grad():
            slope = (function(leaf + step.reshape(leaf.shape)) - function(leaf - step.reshape(leaf.shape))) / 1e-3
        errors.append(abs(float(slope) - float(gradient.reshape(-1)[at])) / scale)
    assert scale > 0 and np.median(errors) < 5e-3


def test_gradients_match_differences(golden: dict[str, Any]) -> None:
    network, points = golden_stage(golden), golden["points"].detach().requires_grad_()
    normals, prior = golden["normals"].detach().requires_grad_(), golden["prior"].detach().reshape(-1).requires_grad_()
    edges, graph, faces, triangles = (golden[name] for name in ("edges", "graph", "faces", "triangle_graph"))

    def total(values: Any) -> Any:
        return values.double() @ weights(len(values)).double()

    assert_gradients_match_differences(lambda x: total(network.point_sampler(x, edges, normals)), points)
    assert_gradients_match_differences(lambda x: total(network.point_sampler(points, edges, x)), normals)
    assert_gradients_match_differences(lambda x: total(network.edge_predictor(x, edges, graph).adjacency), points)
    assert_gradients_match_differences(lambda x: total(network.face_classifier(x, faces, prior, triangles)), points)
    assert_gradients_match_differences(lambda x: total(network.face_classifier(points, faces, x, triangles)), prior)
    theta, last = network.point_sampler.dev_conv_0.theta, network.face_classifier.output.weights

    def with_weights(stage: Any, name: str, x: Any, *inputs: Any) -> Any:
        return total(torch.func.functional_call(stage, {name: x}, inputs))

    assert_gradients_match_differences(lambda x: with_weights(network.point_sampler, "dev_conv_0.theta", x, points, edges, normals), theta)
    assert_gradients_match_differences(lambda x: with_weights(network.face_classifier, "output.weights", x, points, faces, prior, triangles), last)
    assert torch.autograd.gradcheck(lambda x: nmt.in_edge_lengths(x, edges), points.detach().double()[:42].requires_grad_())


def test_names_match_files(tmp_path: Path) -> None:
    for name, n_parameters in (("default", None), ("paper-open", 14_658)):
        network = nmt.Network.shipped(name)
        network.save(tmp_path / "weights.safetensors")
        tensors = read(tmp_path / "weights.safetensors")
        state = network.state_dict()
        assert tensors.keys() == state.keys()
        assert all(torch.equal(tensors[key], state[key]) for key in tensors)
        assert n_parameters in (None, sum(p.numel() for p in network.parameters()))
        shipped = GOLDEN.parents[2] / "weights" / f"{name}.safetensors"
        assert (tmp_path / "weights.safetensors").read_bytes() == shipped.read_bytes()
        again = nmt.Network.from_file(shipped)
        assert again.objective == network.objective and str(again) == str(network)
        stage = nmt.FaceClassifier.from_file(shipped)
        assert all(torch.equal(a, b) for a, b in zip(stage.parameters(), network.face_classifier.parameters(), strict=True))
    assert [path.name for path in tmp_path.iterdir()] == ["weights.safetensors"]


def test_saved_weights_work_in_simplify(tmp_path: Path) -> None:
    points, edges, normals, faces = mesh()
    stage = nmt.PointSampler.shipped("default")
    goal = points[:, 0].detach()
    optimizer = torch.optim.Adam(stage.parameters(), lr=0.02)
    losses = []
    for _ in range(60):
        optimizer.zero_grad()
        loss = (stage(points, edges, normals) - goal).square().mean()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.5 * losses[0]
    # Stages of different networks combine.
    nmt.Network(stage, nmt.EdgePredictor.shipped("paper-open"), nmt.FaceClassifier(1, 4, 3)).save(tmp_path / "mine.safetensors")
    again = nmt.PointSampler.from_file(tmp_path / "mine.safetensors")
    assert torch.equal(again(points, edges, normals), stage(points, edges, normals))
    vertices, corners = torus(60, 50)
    ours = nm.simplify((vertices, corners), ratio=0.1, weights=tmp_path / "mine.safetensors")
    assert ours.report["outcome"] == "reached"
    assert not np.array_equal(ours.vertices, nm.simplify((vertices, corners), ratio=0.1).vertices)


def test_joint_training() -> None:
    points, edges, _, faces = mesh()
    network = nmt.Network(edge_predictor=nmt.EdgePredictor(16, 8), face_classifier=nmt.FaceClassifier(2, 16))
    stages = torch.nn.ModuleList([network.edge_predictor, network.face_classifier])
    optimizer = torch.optim.Adam(stages.parameters(), lr=0.01)
    losses = []
    for _ in range(40):
        optimizer.zero_grad()
        predicted = network.edge_predictor(points, edges)
        candidates = nmt.candidate_faces(points, predicted.graph, predicted.adjacency, faces)
        prior = predicted.adjacency[candidates.entries].mean(1)
        known = {tuple(face) for face in faces.sort(1).values.tolist()}
        goal = torch.tensor([float(tuple(face) in known) for face in candidates.faces.tolist()])
        assert goal.sum() == len(faces)
        loss = torch.nn.functional.binary_cross_entropy(network.face_classifier(points, candidates.faces, prior), goal)
        loss.backward()
        assert all(parameter.grad is not None for parameter in stages.parameters())
        optimizer.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.6 * losses[0]


def test_module_interface() -> None:
    points, edges, normals, _ = mesh()
    stage = nmt.PointSampler.shipped()
    expected = stage(points, edges, normals)
    for other in (copy.deepcopy(stage), pickle.loads(pickle.dumps(stage))):
        assert torch.equal(other(points, edges, normals), expected)
    assert torch.equal(stage(points, torch.cat([edges, edges.flip(1)]).int(), normals), expected)
    doubles = copy.deepcopy(stage).double()
    result = doubles(points.double(), edges, normals.double())
    assert result.dtype == torch.float64
    result.sum().backward()
    assert all(parameter.grad.dtype == torch.float64 for parameter in doubles.parameters())
    drawn = [nmt.PointSampler(seed=seed).score.weights for seed in (3, 3, 4)]
    assert torch.equal(drawn[0], drawn[1]) and not torch.equal(drawn[0], drawn[2])
    leaf = points.clone().requires_grad_()
    loss = stage(leaf, edges, normals).sum()
    loss.backward(retain_graph=True)
    once = leaf.grad.clone()
    loss.backward()
    torch.testing.assert_close(leaf.grad, 2 * once)


def test_compiled() -> None:
    points, edges, normals, _ = mesh()
    stage = nmt.PointSampler.shipped()
    compiled = torch.compile(lambda p: stage(p * 1.0, edges, normals).square().sum(), backend="aot_eager")
    found, expected = (points.clone().requires_grad_() for _ in range(2))
    compiled(found).backward()
    stage(expected, edges, normals).square().sum().backward()
    torch.testing.assert_close(found.grad, expected.grad)


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_in_workers_of_a_loader(context: str) -> None:
    scores = Scores()
    expected = [scores[at] for at in range(4)]
    loader = torch.utils.data.DataLoader(scores, num_workers=2, batch_size=None, multiprocessing_context=context)
    assert all(torch.equal(a, b) for a, b in zip(loader, expected, strict=True))


class Scores(torch.utils.data.Dataset):  # type: ignore[misc]
    def __init__(self) -> None:
        self.stage, self.given = nmt.PointSampler.shipped(), mesh()

    def __len__(self) -> int:
        return 4

    def __getitem__(self, at: int) -> Any:
        points, edges, normals, _ = self.given
        return self.stage(points * (1 + at), edges, normals).detach()


def test_small_and_empty_inputs() -> None:
    network = nmt.Network()
    none = torch.empty((0, 2), dtype=torch.int64)
    for n in (0, 1, 2):
        points = torch.zeros(n, 3)
        assert network.point_sampler(points, none).shape == (n,)
        edges = network.edge_predictor(points, none)
        candidates = nmt.candidate_faces(points, edges.graph, edges.adjacency)
        assert candidates.faces.shape == (0, 3)
        prior = edges.adjacency[candidates.entries].mean(1)
        network.face_classifier(points, candidates.faces, prior).sum().backward()
        assert nmt.in_edge_lengths(points, none).isfinite().all()
        # The graph has no entries.
        assert network.edge_predictor(points, none, none).adjacency.shape == (0,)


def test_errors(tmp_path: Path) -> None:
    points, edges, normals, faces = mesh()
    network = nmt.Network(nmt.PointSampler(6, 1, 4, 4))
    n, prior = len(points), torch.zeros(len(faces))
    sampler, predictor, classifier = network.point_sampler, network.edge_predictor, network.face_classifier
    graph = nmt.extended_graph(points, edges)
    adjacency = torch.ones(len(graph))
    nan = points.clone()
    nan[4, 1] = float("nan")
    wrong = [
        (r"points: .*\(63, 2\).*give n x 3", lambda: sampler(points[:, :2], edges)),
        (r"points: .*int64.*floating", lambda: sampler(points.long(), edges)),
        (r"points: row 4 .*not finite", lambda: sampler(nan, edges)),
        (r"edges: .*give n x 2", lambda: sampler(points, edges.T)),
        (r"edges: .*whole numbers", lambda: sampler(points, edges.float())),
        (rf"edges: row 0 names {n}, but there are only {n}", lambda: sampler(points, torch.tensor([[0, n]]))),
        (r"edges: row 1 names -1", lambda: sampler(points, torch.tensor([[0, 1], [-1, 0]]))),
        (r"normals: 62 rows for 63 points", lambda: sampler(points, edges, normals[1:])),
        (r"graph: .*row by row", lambda: predictor(points, edges, graph.flip(0))),
        (r"graph: .*mirror", lambda: predictor(points, edges, graph[1:][graph[1:, 0] <= graph[1:, 1]])),
        (r"graph: row .* names", lambda: predictor(points[:9], edges[:0], graph)),
        (r"faces: row .* names", lambda: classifier(points[:9], faces, prior)),
        (r"faces: .*give n x 3", lambda: classifier(points, edges, prior)),
        (r"prior: give a finite number for each of 126 faces", lambda: classifier(points, faces, prior[1:])),
        (r"prior: .*finite", lambda: classifier(points, faces, prior + float("inf"))),
        (r"prior: a tensor of shape \(126, 1\)", lambda: classifier(points, faces, prior[:, None])),
        (r"graph: row .* names", lambda: classifier(points, faces[:9], prior[:9], torch.tensor([[0, 9]]))),
        (r"adjacency: .* numbers for .* entries", lambda: nmt.candidate_faces(points, graph, adjacency[1:])),
        (r"adjacency: a tensor of shape", lambda: nmt.candidate_faces(points, graph, adjacency[:, None])),
        (r"surface: row 0 names 99", lambda: nmt.candidate_faces(points, graph, adjacency, torch.tensor([[0, 1, 99]]))),
        (r"face 0 uses a vertex twice", lambda: nmt.vertex_normals(points, torch.tensor([[0, 1, 1]]))),
        (r"knn: -1", lambda: nmt.extended_graph(points, edges, -1)),
        (r"sizes.*point_sampler_width=-1", lambda: nmt.PointSampler(width=-1)),
        (r"sizes.*point_sampler_inputs=4", lambda: nmt.PointSampler(4)),
        (r'no weights "best" ship', lambda: nmt.Network.shipped("best")),
        (r"none.safetensors: No such file", lambda: nmt.Network.from_file(tmp_path / "none.safetensors")),
        (r"test_torch_network.py: not a safetensors file", lambda: nmt.PointSampler.from_file(__file__)),
        (r"nowhere.*: No such file", lambda: network.save(tmp_path / "nowhere" / "w.safetensors")),
    ]  # fmt: skip
    for said, call in wrong:
        with pytest.raises(nm.NeuralMeshError, match=said) as raised:
            call()
        assert "\n" not in str(raised.value)
    with torch.no_grad():
        sampler.score.bias.fill_(float("nan"))
    with pytest.raises(nm.NeuralMeshError, match="point_sampler.score.bias.*not finite"):
        sampler(points, edges)
    sampler.score.bias = torch.nn.Parameter(torch.zeros(1, 2))
    with pytest.raises(nm.NeuralMeshError, match=r"point_sampler.score.bias.*shape \[1, 2\]"):
        sampler(points, edges)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU")
def test_on_a_gpu() -> None:
    points, edges, normals, _ = mesh()
    stage = nmt.PointSampler.shipped()
    expected = stage(points, edges, normals)
    moved = copy.deepcopy(stage).cuda()
    leaf = points.cuda().requires_grad_()
    scores = moved(leaf, edges.cuda(), normals.cuda())
    assert scores.device.type == "cuda"
    torch.testing.assert_close(scores.cpu(), expected)
    scores.sum().backward()
    assert leaf.grad.device.type == "cuda" and all(parameter.grad.device.type == "cuda" for parameter in moved.parameters())

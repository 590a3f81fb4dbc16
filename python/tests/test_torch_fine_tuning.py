"""Fine-tuning of vertex scores: the measure is that of `compare`, and draws of other seeds have less of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch as nmt  # noqa: E402
from conftest import MESHES, torus  # noqa: E402
from neural_mesh.torch import losses  # noqa: E402


def read(name: str) -> tuple[Any, Any]:
    vertices, faces = nm.simplify(MESHES / name, ratio=1.0, weld=True)
    return torch.from_numpy(np.asarray(vertices, np.float32)), torch.from_numpy(np.asarray(faces, np.int64))


def small_torus() -> tuple[Any, Any]:
    vertices, faces = torus(40, 20)
    return torch.from_numpy(vertices), torch.from_numpy(faces).long()


@pytest.fixture(scope="module")
def layer() -> Any:
    return nmt.Simplifier.from_weights("paper-open")


def drawn(layer: Any, mesh: Any, ratio: float, scores: Any, seed: int) -> Any:
    with torch.no_grad():
        return layer(*mesh, ratio, scores=scores, seed=seed)


@pytest.mark.parametrize("name", ["spot.ply", "suzanne.ply", None])
def test_curvature_errors_are_those_of_compare(layer: Any, name: str | None) -> None:
    vertices, faces = read(name) if name else small_torus()
    result = drawn(layer, (vertices, faces), 0.1, None, 1)
    # A file has only vertices that faces have.
    used, corners = torch.unique(result.faces, return_inverse=True)
    samples = result.samples[used]
    found = sum(float(x.double().mean()) for x in losses.curvature_errors(vertices, samples))
    light = vertices[samples].numpy(), corners.numpy()
    assert found == pytest.approx(nm.compare((vertices.numpy(), faces.numpy()), light, samples=500)["curvature_error"], rel=1e-5)


@pytest.mark.parametrize("draw", ["scattered", "multinomial"])
def test_draws_of_other_seeds_keep_more_curvature(draw: str) -> None:
    layer, mesh = nmt.Simplifier.from_weights("paper-open", draw=draw), read("spot.ply")
    found = nmt.fine_tune_scores(layer, *mesh, 0.1, steps=15, seed=1)
    assert found.error < 0.85 and found.distance <= 1.1
    errors, distances = [], []
    for scores in (None, found.scores):
        results = [drawn(layer, mesh, 0.1, scores, 100 + seed) for seed in range(3)]
        measured = [sum(float(x.mean()) for x in losses.curvature_errors(mesh[0], result.samples)) for result in results]
        errors.append(np.mean(measured))
        distances.append(np.mean([float(torch.cdist(mesh[0], x.vertices).amin(1).square().mean()) for x in results]))
        assert all(len(result.faces) > 400 for result in results)
    assert errors[1] < 0.9 * errors[0] and distances[1] < 1.2 * distances[0]


def test_an_objective_of_ones_own_moves_samples(layer: Any) -> None:
    mesh = small_torus()
    is_above = mesh[0][:, 2] > 0

    def distance_above(samples: Any, nearest: Any) -> tuple[Any, Any]:
        square = (mesh[0] - mesh[0][samples[nearest]]).square().sum(1)
        return torch.where(is_above, square, 0), torch.zeros(len(samples))

    found = nmt.fine_tune_scores(layer, *mesh, 0.2, objective=distance_above, most_distance=4.0, steps=30)
    before, after = (float(is_above[drawn(layer, mesh, 0.2, scores, 7).samples].float().mean()) for scores in (None, found.scores))
    assert found.error < 0.8 and after > before + 0.15
    bound = nmt.fine_tune_scores(layer, *mesh, 0.2, objective=distance_above, most_distance=1.0, steps=10)
    assert bound.distance <= 1.0 and bound.error <= 1.0


def test_scores_that_are_given(layer: Any) -> None:
    mesh = small_torus()
    own = drawn(layer, mesh, 0.1, None, 3)
    assert torch.equal(drawn(layer, mesh, 0.1, own.scores, 3).faces, own.faces)
    as_they_were = nmt.fine_tune_scores(layer, *mesh, 0.1, steps=0)
    assert torch.equal(as_they_were.scores, own.scores) and as_they_were[1:] == (1.0, 1.0)
    scores = own.scores.clone().requires_grad_()
    layer(*mesh, 0.1, scores=scores, seed=3).probabilities.sum().backward()
    assert float(scores.grad.abs().sum()) > 0
    given = {"steps": 2, "most_distance": 9.0, "seed": 4}
    by_share, by_number = nmt.fine_tune_scores(layer, *mesh, 0.1, **given), nmt.fine_tune_scores(layer, *mesh, n_samples=80, **given)
    assert torch.equal(by_share.scores, by_number.scores)
    # Vertices are of any precision, scores of the network's.
    assert nmt.fine_tune_scores(layer, mesh[0].double(), mesh[1], 0.1, **given).scores.dtype == torch.float32
    # Of all vertices there is nothing to choose.
    assert nmt.fine_tune_scores(layer, *mesh, 1.0, steps=2).error == 1.0
    assert nmt.fine_tune_scores(layer, *mesh, n_samples=2, steps=2).error <= 1.0


def test_errors(layer: Any) -> None:
    vertices, faces = small_torus()
    for call, said in (
        (lambda: layer(vertices, faces, 0.1, scores=torch.zeros(3)), "scores: give a finite number for each of the 800 vertices"),
        (lambda: layer(vertices, faces, 0.1, scores=torch.full((800,), float("nan"))), "scores: give a finite number"),
        (lambda: nmt.fine_tune_scores(layer, vertices, None, 0.1), "give vertices and faces of one mesh"),
        (lambda: nmt.fine_tune_scores(layer, [vertices] * 2, [faces] * 2, 0.1), "give vertices and faces of one mesh"),
        (lambda: nmt.fine_tune_scores(layer, vertices, faces), "give exactly one of ratio and n_samples"),
        (lambda: nmt.fine_tune_scores(layer, vertices, faces, 2.0), "ratio: 2.0: give a share above 0, at most 1"),
    ):
        with pytest.raises(nm.NeuralMeshError, match=said):
            call()

"""Expected errors: descent lowers them, and the estimated variance of the gradient is right."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch  # noqa: E402
from conftest import torus  # noqa: E402

WAVY = torus(60, 30)


def upper_error(original, result):
    errors = np.linalg.norm(original.vertices - result.vertices[result.vertex_of], axis=1)
    return np.where(original.vertices[:, 2] > 0, errors, 0.0)


def test_descent_moves_vertices_to_where_errors_matter():
    vertices, faces = WAVY
    scores = torch.zeros(len(vertices), requires_grad=True)
    optimiser = torch.optim.Adam([scores], lr=0.2)
    values = []
    for seed in range(12):
        optimiser.zero_grad()
        value = neural_mesh.torch.expected(upper_error, vertices, faces, scores, ratio=0.1, seed=seed)
        value.backward()
        optimiser.step()
        values.append(value.item())
    assert values[-1] < 0.9 * values[0], values
    upper = vertices[:, 2] > 0
    assert scores.detach().numpy()[upper].mean() > scores.detach().numpy()[~upper].mean() + 0.2


def test_variance_matches_other_seeds():
    vertices, faces = WAVY
    scores = torch.zeros(len(vertices), dtype=torch.float64)
    gradients, variances = [], []
    for seed in range(24):
        moved = scores.clone().requires_grad_()
        value, variance = neural_mesh.torch.expected(upper_error, vertices, faces, moved, ratio=0.1, probes=3, seed=seed, with_variance=True)
        value.backward()
        gradients.append(moved.grad.numpy())
        variances.append(variance.numpy())
    told, seen = np.mean(variances), np.var(gradients, axis=0, ddof=1).mean()
    assert 0.7 < told / seen < 1.4, (told, seen)


def test_wrong_scores_are_rejected_in_one_line():
    vertices, faces = WAVY
    with pytest.raises(nm.NeuralMeshError, match="scores: 3 numbers for"):
        neural_mesh.torch.expected(upper_error, vertices, faces, torch.zeros(3), ratio=0.1)
    with pytest.raises(nm.NeuralMeshError, match="finite score"):
        neural_mesh.torch.expected(upper_error, vertices, faces, torch.full((len(vertices),), float("nan")), ratio=0.1)
    with pytest.raises(ZeroDivisionError):
        neural_mesh.torch.expected(lambda *_: 1 / 0, vertices, faces, torch.zeros(len(vertices)), ratio=0.1)

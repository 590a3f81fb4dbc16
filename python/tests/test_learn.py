"""Training of weights for an objective: training, interruption, resuming, and invalid objectives."""

import numpy as np
import pytest
from conftest import torus

import neural_mesh as nm

WAVY = torus(60, 30)


def _is_inner(vertices):
    """Returns whether vertices are on the inner half of the torus, which is visible in their one-ring."""
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    return radius < 0.5 * (radius.min() + radius.max())


def inner_error(original, result):
    """Returns the distances of the inner vertices to their result vertices; outer vertices count 0."""
    errors = np.linalg.norm(original.vertices - result.vertices[result.vertex_of], axis=1)
    return np.where(_is_inner(original.vertices), errors, 0.0)


def _meshes():
    rng = np.random.default_rng(3)
    return {f"mesh-{at}": (WAVY[0] * (1 + 0.05 * rng.random(3)), WAVY[1]) for at in range(3)}


_QUICK = {"probes": 1, "rotation": False, "scale": 0.0, "ratio_min": 0.2, "ratio_max": 0.3, "validation_ratios": [0.2]}


def test_weights_learn_where_errors_matter(tmp_path):
    seen = []

    def progress(kind, epoch, done, of, numbers):
        seen.append((kind, epoch, done, dict(numbers)))

    settings = {**_QUICK, "probes": 4, "learning_rate": 0.02}
    file = nm.train(_meshes(), inner_error, out=tmp_path, epochs=6, settings=settings, progress=progress)
    assert sum(kind == "step" for kind, *_ in seen) == 18 and seen[-1][:2] == ("epoch", 6)
    shares = []
    for weights in (None, file):
        vertices, _ = nm.simplify(WAVY, ratio=0.2, weights=weights)
        shares.append(_is_inner(vertices).mean())
    assert shares[1] > shares[0] + 0.05, shares


def test_resumed_training_gives_equal_weights(tmp_path):
    meshes, calls = _meshes(), []

    def often(original, result):
        calls.append(1)
        if len(calls) == 9:
            raise RuntimeError("enough")
        return inner_error(original, result)

    whole = nm.train(meshes, inner_error, out=tmp_path / "whole", epochs=2, settings=_QUICK)
    with pytest.raises(RuntimeError, match="enough"):
        nm.train(meshes, often, out=tmp_path / "twice", epochs=2, settings=_QUICK, threads=1)
    twice = nm.train(meshes, inner_error, out=tmp_path / "twice", epochs=2, settings=_QUICK, resume=True)
    assert open(whole, "rb").read() == open(twice, "rb").read()


def test_integer_errors_and_named_objectives(tmp_path):
    meshes = _meshes()
    nm.train(meshes, lambda original, result: len(result.faces) ** 0.5, out=tmp_path / "a", epochs=1, settings=_QUICK)
    nm.train(meshes, "shape", out=tmp_path / "b", epochs=1, validation=["mesh-2"], settings=_QUICK)
    assert (tmp_path / "b/run/best.safetensors").exists()


def test_training_errors_are_one_line(tmp_path):
    meshes = _meshes()
    with pytest.raises(nm.NeuralMeshError, match="the objective returned 7 numbers: return one number"):
        nm.train(meshes, lambda *_: np.ones(7), out=tmp_path / "a", settings=_QUICK)
    with pytest.raises(nm.NeuralMeshError, match="must be one of"):
        nm.train(meshes, "nonsense", out=tmp_path / "b", settings=_QUICK)
    with pytest.raises(nm.NeuralMeshError, match="unknown setting `probs`"):
        nm.train(meshes, inner_error, out=tmp_path / "c", settings={"probs": 3})
    with pytest.raises(nm.NeuralMeshError, match="mesh-0.ply: would keep fewer than 50 vertices"):
        nm.train({"mesh-0": torus(8, 8)}, inner_error, out=tmp_path / "f", settings=_QUICK)
    with pytest.raises(nm.NeuralMeshError, match="without folders"):
        nm.train({"../x": WAVY}, inner_error, out=tmp_path / "d")
    with pytest.raises(nm.NeuralMeshError, match="already contains a training"):
        for _ in range(2):
            nm.train(tmp_path / "b/meshes", inner_error, out=tmp_path / "e", epochs=1, settings=_QUICK)


def test_paper_weights_are_rejected_by_closed_assembly(tmp_path):
    small = {"point_sampler_layers": 1, "point_sampler_width": 4, "edge_predictor_width": 4, "attention_width": 4,
             "face_classifier_layers": 1, "face_classifier_width": 4, "edge_knn": 5, "face_knn": 5}  # fmt: skip
    file = nm.train(_meshes(), "paper", out=tmp_path, epochs=1, init=None, settings={**_QUICK, **small})
    with pytest.raises(nm.NeuralMeshError, match='was trained with the objective "paper"'):
        nm.simplify(WAVY, ratio=0.2, weights=file)
    assert nm.simplify(WAVY, ratio=0.5, weights=file, assembly="paper").faces.shape[1] == 3

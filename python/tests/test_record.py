"""Records: values equal the result, and gradients match differences, in numpy, torch and jax."""

from __future__ import annotations

import multiprocessing
import pickle
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import torus

SIZES: list[dict[str, Any]] = [{"ratio": 0.3}, {"n_vertices": 60}, {"n_faces": 200}, {"n_faces": "20%"}, {"ratio": 0.3, "subset": True}, {"ratio": 1.0}]


@pytest.mark.parametrize("size", SIZES)
def test_values_equal_result_and_gradients_match_differences(size: dict[str, Any]) -> None:
    vertices, faces = torus(24, 16, np.float64)
    record = nm.record(vertices, faces, **size)
    again = {name.removeprefix("n_"): value for name, value in size.items()}
    light = nm.simplify((vertices, faces), effort="standard", **again)
    np.testing.assert_array_equal(record.faces, light.faces)
    np.testing.assert_allclose(record.positions(vertices), light.vertices, atol=1e-6)
    random = np.random.default_rng(1)
    along, to_result = random.normal(size=vertices.shape), random.normal(size=(record.n_output, 3))
    slope = (record.backward(vertices, to_result) * along).sum()
    step = 1e-6
    ahead, behind = (record.positions(vertices + s * along) for s in (step, -step))
    assert ((ahead - behind) * to_result).sum() / (2 * step) == pytest.approx(slope, rel=1e-5, abs=1e-4)


def test_far_from_the_origin_and_in_single_precision() -> None:
    vertices, faces = torus(24, 16, np.float64)
    record = nm.record(vertices + 1e6, faces, ratio=0.3)
    near = nm.record(vertices.astype(np.float32), faces, ratio=0.3)
    result = near.positions(vertices.astype(np.float32))
    assert result.dtype == np.float32
    assert np.abs(record.positions(vertices + 1e6).mean(0) - 1e6 - result.mean(0)).max() < 0.05


def test_features_are_pooled() -> None:
    vertices, faces = torus(24, 16)
    record = nm.record(vertices, faces, ratio=0.2)
    pooled = record.pool(vertices)
    assert pooled.shape == (record.n_output, 3)
    for output in (0, 5, record.n_output - 1):
        np.testing.assert_allclose(pooled[output], vertices[record.output_vertices == output].mean(0), rtol=1e-5)
    assert np.abs(pooled - record.positions(vertices)).mean() < 0.1


def test_features_are_pooled_over_the_regions_of_the_paper() -> None:
    vertices, faces = torus(30, 20)
    record = nm.record(vertices, faces, ratio=0.2, assembly="paper")
    regions = record.output_vertices
    assert (regions >= 0).all() and (np.bincount(regions, minlength=record.n_output) > 0).all()
    pooled = record.pool(vertices)
    np.testing.assert_allclose(pooled[3], vertices[regions == 3].mean(0), rtol=1e-5)
    # A region lies around its vertex.
    assert np.abs(pooled - record.positions(vertices)).mean() < 0.1


def test_welded_vertices_share_a_result_vertex() -> None:
    vertices, faces = torus(24, 16)
    twice = np.concatenate([vertices, vertices])
    mixed = faces.copy()
    mixed[::2] += len(vertices)
    outputs = nm.record(twice, mixed, ratio=0.2).output_vertices
    np.testing.assert_array_equal(outputs[: len(vertices)], outputs[len(vertices) :])


def read_in_child(record: nm.Record) -> Any:
    vertices, _ = torus(24, 16, np.float64)
    return record.positions(vertices)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_records_are_sent_to_other_processes(method: str) -> None:
    vertices, faces = torus(24, 16, np.float64)
    record = nm.record(vertices, faces, ratio=0.3)
    with multiprocessing.get_context(method).Pool(1) as pool:
        np.testing.assert_array_equal(pool.map(read_in_child, [record])[0], record.positions(vertices))
    again = pickle.loads(pickle.dumps(record))
    np.testing.assert_array_equal(again.output_vertices, record.output_vertices)


def test_wrong_shapes_are_rejected() -> None:
    vertices, faces = torus(24, 16)
    with pytest.raises(nm.OptionError, match="exactly one of ratio"):
        nm.record(vertices, faces)
    record = nm.record(vertices, faces, ratio=0.3)
    with pytest.raises(nm.NeuralMeshError, match="3 rows for a record of 384"):
        record.positions(vertices[:3])
    with pytest.raises(nm.NeuralMeshError, match="1 rows for"):
        record.backward(vertices, vertices[:1])

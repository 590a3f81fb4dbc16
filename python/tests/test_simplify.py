"""Simplification of arrays: sizes, types, options, and equality with the library's result."""

from __future__ import annotations

import dataclasses
import multiprocessing
import pickle
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import Pair, edge_counts, grid, torus


@pytest.mark.parametrize(
    ("size", "n_vertices", "n_faces"),
    [({"ratio": 0.1}, 240, 480), ({"vertices": 300}, 300, 600), ({"faces": 500}, 250, 500),
     ({"ratio": "10%"}, 240, 480), ({"vertices": "12.5%"}, 300, 600), ({"faces": "0.5k"}, 250, 500), ({"faces": "10%"}, 240, 480)],
)  # fmt: skip
def test_sizes(size: dict[str, Any], n_vertices: int, n_faces: int) -> None:
    light = nm.simplify(torus(60, 40), **size)
    v, f = light
    assert (len(v), len(f)) == (n_vertices, n_faces)
    assert light.outcome == "reached"
    assert (edge_counts(f) == 2).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_precision_is_kept(dtype: Any) -> None:
    vertices, faces = torus(60, 40, dtype)
    far = vertices + np.asarray([5e6, 0, 0] if dtype == np.float64 else [0, 0, 0], dtype)
    v, f = nm.simplify((far, faces), ratio=0.2, subset=True)
    assert v.dtype == dtype and f.dtype == np.int32
    # Each is an exact vertex of the input.
    assert {tuple(row) for row in v} <= {tuple(row) for row in far}


def test_sources_number_input_vertices() -> None:
    vertices, faces = torus(40, 30)
    # The first two vertices are unreferenced.
    vertices, faces = np.concatenate([np.full((2, 3), 9, np.float32), vertices]), faces + 2
    light = nm.simplify((vertices, faces), ratio=0.2, subset=True)
    assert light.sources is not None
    np.testing.assert_array_equal(vertices[light.sources], light.vertices)


def test_result_is_independent_of_threads() -> None:
    mesh = torus(200, 150)
    one, two = (nm.simplify(mesh, ratio=0.05, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.vertices, two.vertices)
    np.testing.assert_array_equal(one.faces, two.faces)
    assert (one.report["threads"], two.report["threads"]) == (1, 2)


@pytest.mark.parametrize("faces_dtype", [np.int64, np.uint32, np.int16, np.uint64])
def test_faces_of_any_integer_type(faces_dtype: Any) -> None:
    vertices, faces = torus(30, 20)
    expected = nm.simplify((vertices, faces), ratio=0.3)
    light = nm.simplify((vertices.tolist(), faces.astype(faces_dtype)), ratio=0.3)
    np.testing.assert_array_equal(light.faces, expected.faces)


def test_strided_arrays_are_read_and_unchanged() -> None:
    vertices, faces = torus(30, 20)
    expected = nm.simplify((vertices, faces), ratio=0.3)
    wide = np.zeros((len(vertices), 6), np.float32)
    wide[:, ::2] = vertices
    fortran = np.asfortranarray(faces)
    kept = wide.copy()
    light = nm.simplify((wide[:, ::2], fortran), ratio=0.3)
    np.testing.assert_array_equal(light.vertices, expected.vertices)
    np.testing.assert_array_equal(wide, kept)


def test_error_is_met_and_proved() -> None:
    light = nm.simplify(torus(60, 40), error="0.5%")
    assert light.report["certified"]["upper_percent"] <= 0.5
    figures = nm.compare(torus(60, 40), light, samples=20_000)
    largest = figures["distance_max"]
    assert largest is not None and largest <= light.report["certified"]["upper_percent"]


def test_missed_bound_raises_with_result() -> None:
    # A torus needs more than four faces.
    vertices, faces = torus(20, 12, np.float64)
    with pytest.raises(nm.NotReachedError) as caught:
        nm.simplify((vertices, faces), faces=4, strict=True)
    assert "stopped" in str(caught.value)
    assert len(caught.value.result.faces) > 4
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and len(again.result.faces) == len(caught.value.result.faces)


def test_levels_of_detail() -> None:
    mesh = torus(60, 40)
    levels = nm.lods(mesh, [0.5, 0.25, 0.1], check=True)
    assert [len(light.vertices) for light in levels] == [1200, 600, 240]
    np.testing.assert_array_equal(levels[0].vertices, nm.simplify(mesh, ratio=0.5, effort="standard").vertices)
    distances = [light.report["distance"]["mean_percent"] for light in levels]
    assert distances == sorted(distances) and distances[0] > 0
    assert [light.report["output"]["vertices"] for light in levels] == [1200, 600, 240]


def test_importance_of_vertices() -> None:
    vertices, faces = torus(60, 40)
    light = nm.simplify((vertices, faces), ratio=0.1, importance=np.where(vertices[:, 0] > 0, 30.0, 1.0))
    assert (light.vertices[:, 0] > 0).mean() > 0.7
    with pytest.raises(nm.OptionError, match="give one for each"):
        nm.simplify((vertices, faces), ratio=0.1, importance=[1.0, 2.0])


def test_locked_boundaries_stay() -> None:
    vertices, faces, _ = grid(20)
    light = nm.simplify((vertices, faces), ratio=0.3, lock_boundaries=True)
    boundary = vertices[(vertices[:, :2] == 0).any(1) | (vertices[:, :2] == 1).any(1)]
    assert {tuple(row) for row in boundary} <= {tuple(row) for row in light.vertices}


def test_holes_and_solids() -> None:
    vertices, faces = torus(40, 30)
    open_faces = np.delete(faces, [7, len(faces) // 2 + 7], axis=0)
    closed = nm.simplify((vertices, open_faces), ratio=0.3, fill_holes=True)
    assert (edge_counts(closed.faces) == 2).all() and closed.report["repaired"]["holes_filled"] == 1
    solid = nm.simplify((vertices, open_faces), ratio=0.3, printable="1%")
    assert (edge_counts(solid.faces) == 2).all()


def test_map_from_input_to_result_vertices() -> None:
    vertices, faces = torus(40, 30)
    # Every vertex is duplicated, and the copies are welded.
    twice = np.concatenate([vertices, vertices])
    mixed = faces.copy()
    mixed[::2] += len(vertices)
    light = nm.simplify((twice, mixed), ratio=0.2, map=True)
    way = light.map
    assert way is not None
    n = len(vertices)
    np.testing.assert_array_equal(way.output_vertices[:n], way.output_vertices[n:])
    assert set(way.output_vertices) == set(range(len(light.vertices)))
    np.testing.assert_array_equal(way.output_vertices[way.input_vertices], np.arange(len(light.vertices)))
    assert way.corner_faces.shape == (len(light.faces), 3) and way.corner_weights.shape == (len(light.faces), 3, 3)
    points = (vertices[faces[way.corner_faces]] * way.corner_weights[..., None]).sum(2)
    assert np.abs(points - light.vertices[light.faces]).max() < 0.1
    assert nm.simplify((vertices, faces), ratio=0.2).map is None


def test_results_are_frozen() -> None:
    light = nm.simplify(torus(30, 20), ratio=0.3)
    with pytest.raises(dataclasses.FrozenInstanceError):
        light.vertices = None  # type: ignore[misc]
    assert repr(light) == "Light(180 vertices, 360 faces, reached)"
    again = pickle.loads(pickle.dumps(light))
    np.testing.assert_array_equal(again.vertices, light.vertices)


def test_results_can_be_simplified_and_compared() -> None:
    mesh = torus(60, 40)
    light = nm.simplify(nm.simplify(mesh, ratio=0.5), ratio=0.5)
    assert len(light.vertices) == 600
    figures = nm.compare(mesh, light, nm.simplify(mesh, ratio=0.05))
    means = [result["distance_mean"] for result in figures.results]
    assert means[0] is not None and means[1] is not None and 0 < means[0] < means[1]
    assert figures.units["distance_mean"] == "% of diagonal"


def simplify_in_child(mesh: Pair) -> int:
    return len(nm.simplify(mesh, faces=200).faces)


def test_forked_children_simplify() -> None:
    mesh = torus(60, 40)
    nm.simplify(mesh, ratio=0.5)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map(simplify_in_child, [mesh] * 4) == [200] * 4


def test_point_cloud() -> None:
    vertices, _ = torus(50, 30, np.float64)
    light = nm.mesh_points(vertices, ratio=0.5, keep_points=True)
    assert light.report["closed"] and len(light.faces) == 1500 and light.sources is not None
    np.testing.assert_array_equal(vertices[light.sources], light.vertices)
    placed = nm.mesh_points(vertices, ratio=0.5)
    assert placed.report["closed"] and not np.array_equal(vertices[placed.sources], placed.vertices)
    assert light.report["points"] == 1500


def test_purpose_poses() -> None:
    mesh = torus(40, 30)
    plain = nm.simplify(mesh, ratio=0.2)
    bending = nm.simplify(mesh, ratio=0.2, for_="poses")
    assert len(bending.vertices) == len(plain.vertices) and not np.array_equal(bending.vertices, plain.vertices)
    assert any("assumed to bend" in note for note in bending.report["notes"])


def test_offsets_in_a_pose_are_counted_and_carried() -> None:
    v, f = torus(60, 30)
    # The pose raises a bump where the surface at rest is smooth.
    height = 0.3 * np.exp(-((v - [1.0, 0.0, 0.3]) ** 2).sum(1) / 0.02)
    offsets = (height[:, None] * [0, 0, 1]).astype(np.float32)
    errors = []
    for purpose in ("shape", "poses"):
        light = nm.simplify((v, f), faces=400, attributes={"morph_0": offsets}, for_=purpose)
        positions, triangles, values = light.split()
        errors.append(nm.compare((v + offsets, f), (positions + values["morph_0"], triangles))["distance_max"])
    assert errors[1] < 0.5 * errors[0], errors

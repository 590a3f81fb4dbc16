"""The small path: arrays with nothing to keep but their shape."""

from __future__ import annotations

import typing
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import edge_counts, grid, torus
from neural_mesh._compare import Figure
from neural_mesh._options import Options, OptionsWithoutRatio
from neural_mesh._report import Report


def is_plain(light: nm.Light[Any]) -> bool:
    return "estimated_error" in light.report


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("size", [{"ratio": 0.1}, {"ratio": "29%"}, {"vertices": 200}, {"faces": 301}, {"faces": "10%"}])
def test_results_are_closed_near_and_of_the_size_asked_for(dtype: Any, size: dict[str, Any]) -> None:
    vertices, faces = torus(60, 40, dtype)
    light = nm.simplify((vertices, faces), **size)
    assert is_plain(light) and light.reached and light.vertices.dtype == dtype and light.faces.dtype == np.int32
    (kind, value), n = next(iter(size.items())), len(faces) if "faces" in size else len(vertices)
    asked = value if isinstance(value, int) else int(float(str(value).rstrip("%")) * n / (100 if "%" in str(value) else 1))
    got = len(light.faces) if kind == "faces" else len(light.vertices)
    # A merge in a closed surface removes two faces.
    assert got == asked - (kind == "faces" and asked % 2)
    assert (edge_counts(light.faces) == 2).all() and len(light.vertices) - len(light.faces) // 2 == 0
    whole = nm.simplify((vertices, faces), effort="standard", **size)
    distances = [nm.compare((vertices, faces), result)["distance_mean"] or 0.0 for result in (light, whole)]
    assert not is_plain(whole) and 0 < distances[0] < 1.5 * distances[1]
    assert set(Report.__required_keys__) <= set(light.report) and light.report["target"] == whole.report["target"]


def test_positions_far_from_the_origin_keep_their_digits() -> None:
    vertices, faces = torus(40, 30, np.float64)
    near, far = (nm.simplify((vertices + shift, faces), ratio=0.2) for shift in (0.0, 2.0**30))
    assert is_plain(far)
    distances = [nm.compare((vertices, faces), (light.vertices - shift, light.faces))["distance_mean"] for light, shift in ((near, 0.0), (far, 2.0**30))]
    assert distances[1] == pytest.approx(distances[0], rel=0.1)


def test_any_number_of_threads_gives_the_same_bits() -> None:
    mesh = torus(200, 100)
    one, two = (nm.simplify(mesh, ratio=0.1, threads=threads) for threads in (1, 2))
    assert is_plain(one) and np.array_equal(one.vertices, two.vertices) and np.array_equal(one.faces, two.faces)


def test_many_meshes_are_as_each_alone() -> None:
    meshes = [torus(n, 20) for n in range(20, 40)]
    meshes[3] = (meshes[3][0], np.concatenate([meshes[3][1], meshes[3][1][:1]]))
    lights = nm.simplify_many(meshes, ratio=0.3)
    assert [is_plain(light) for light in lights] == [i != 3 for i in range(20)]
    for mesh, light in zip(meshes, lights):
        alone = nm.simplify(mesh, ratio=0.3)
        assert np.array_equal(light.vertices, alone.vertices) and np.array_equal(light.faces, alone.faces)
    assert nm.simplify_many([], ratio=0.3) == []
    assert not any(is_plain(light) for light in nm.simplify_many(meshes[:2], ratio=0.3, effort="standard"))
    with pytest.raises(nm.OptionError, match="on_dirty"):
        nm.simplify_many(meshes, ratio=0.3, on_dirty="rais")  # type: ignore[typeddict-item]


def test_boundaries_stay_where_they_are_locked() -> None:
    vertices, faces, _ = grid(20)
    light = nm.simplify((vertices, faces), ratio=0.3, lock_boundaries=True)
    assert is_plain(light) and (edge_counts(light.faces) == 1).sum() == 80


def test_meshes_that_are_not_clean_take_the_whole_way() -> None:
    vertices, faces = torus(30, 20)
    broken = vertices.copy()
    broken[5] = np.nan
    cases = [
        ((broken, faces), {"non_finite_faces": 6}),
        ((vertices, np.concatenate([faces, [[0, 1, 600]]])), {"out_of_range_faces": 1}),
        ((vertices, np.concatenate([faces, [[0, 0, 1]]])), {"degenerate_faces": 1}),
        ((vertices, np.concatenate([faces, faces[:1]])), {"duplicate_faces": 1}),
        ((vertices[faces].reshape(-1, 3), np.arange(3600).reshape(-1, 3)), {"welded_vertices": 3000}),
    ]
    for mesh, cleaned in cases:
        light = nm.simplify(mesh, ratio=0.5, on_dirty="ignore")
        assert not is_plain(light) and light.cleaned.items() >= cleaned.items()


def test_vertices_without_a_face_do_not_count() -> None:
    vertices, faces = torus(30, 20)
    light = nm.simplify((np.concatenate([vertices, vertices[:100] + 9]), faces), ratio=0.5)
    assert is_plain(light) and len(light.vertices) == 300 and light.cleaned == {"unreferenced_vertices": 100}
    # Nor do they take digits of double precision.
    vertices, faces = torus(30, 20, np.float64)
    alone, beside = (nm.simplify((points, faces), ratio=0.5) for points in (vertices, np.concatenate([vertices, [[1e9, 0, 0]]])))
    assert np.array_equal(alone.vertices, beside.vertices)


def test_what_merges_cannot_reach_takes_the_whole_way() -> None:
    # Two tetrahedra are left of two spheres, so that one has to go.
    vertices, faces = torus(30, 20)
    both = np.concatenate([vertices, 0.1 * vertices + 5]), np.concatenate([faces, faces + 600])
    with pytest.warns(nm.NeuralMeshWarning):
        light = nm.simplify(both, vertices=8)
    assert not is_plain(light)


def test_copies_stay_apart_where_nothing_is_welded() -> None:
    vertices, faces = torus(30, 20)
    both = np.concatenate([vertices, vertices]), np.concatenate([faces, faces + 600])
    light = nm.simplify(both, ratio=0.5, weld=False)
    assert is_plain(light) and (edge_counts(light.faces) == 2).all() and len(light.vertices) == 600


@pytest.mark.filterwarnings("ignore::neural_mesh.NeuralMeshWarning")
def test_progress_rises_also_where_the_whole_way_follows() -> None:
    vertices, faces = torus(300, 200)
    spheres = np.concatenate([vertices, 0.1 * vertices + 5]), np.concatenate([faces, faces + len(vertices)])
    for mesh, options in (((vertices, faces), {"ratio": 0.1}), (spheres, {"vertices": 8, "on_dirty": "ignore"})):
        heard: list[float] = []
        nm.simplify(mesh, progress=lambda done, stage: heard.append(done), **options)
        assert heard == sorted(heard) and heard[-1] == 1.0 and len(heard) > 1

    def stop(done: float, stage: str) -> None:
        raise KeyError

    with pytest.raises(KeyError):
        nm.simplify((vertices, faces), ratio=0.1, progress=stop)


def test_names_for_type_checkers_are_those_of_the_package() -> None:
    assert set(OptionsWithoutRatio.__annotations__) == set(Options.__annotations__) - {"ratio"}
    comparison = nm.compare(torus(20, 10), torus(20, 10))
    assert list(comparison.units) == list(typing.get_args(Figure))


def test_pymeshlab() -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    vertices, faces = torus(40, 30, np.float64)
    mesh = pymeshlab.Mesh(vertices, faces)
    light = nm.simplify(mesh, ratio=0.2)
    assert isinstance(light.mesh, pymeshlab.Mesh) and light.mesh.face_number() == len(light.faces)
    meshes = pymeshlab.MeshSet()
    colours = np.concatenate([np.clip(np.abs(vertices), 0, 1), np.ones((len(vertices), 1))], 1)
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_color_matrix=colours))
    result = nm.simplify(meshes, ratio=0.2).mesh
    assert isinstance(result, pymeshlab.MeshSet) and result.current_mesh().has_vertex_color()
    expected = np.clip(np.abs(result.current_mesh().vertex_matrix()), 0, 1)
    assert np.abs(result.current_mesh().vertex_color_matrix()[:, :3] - expected).max() < 0.1

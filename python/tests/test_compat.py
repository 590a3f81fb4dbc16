"""Replacements for functions of other packages: signatures and meaning of sizes."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import edge_counts, grid, torus
from neural_mesh.compat import fast_simplification, pyfqmr
from neural_mesh.compat import open3d as compat_open3d
from neural_mesh.compat import trimesh as compat_trimesh


def test_fast_simplification() -> None:
    points, faces = torus(60, 40)
    v, f = fast_simplification.simplify(points, faces, 0.75)
    assert len(f) == 1200 and v.dtype == np.float64 and f.dtype == np.int32 and (edge_counts(f) == 2).all()
    v, f, collapses = fast_simplification.simplify(points, faces, target_count=1000, return_collapses=True)
    assert len(f) == 1000 and len(collapses) == len(points) - len(v)
    # Points merge only into points that stay.
    assert not set(collapses[:, 0]) & set(collapses[:, 1])
    for wrong, says in [({}, "must specify"), ({"target_reduction": 2}, "between 0 and 1"), ({"target_count": 99999}, "less than")]:
        with pytest.raises(ValueError, match=says):
            fast_simplification.simplify(points, faces, **wrong)


def test_fast_simplification_keeps_borders_and_is_lossless() -> None:
    points, faces, _ = grid(20)
    v, f = fast_simplification.simplify(points, faces, 0.7, preserve_border=True)
    assert (edge_counts(f) == 1).sum() == 80
    flat = points * [1, 1, 0]
    v, f = fast_simplification.simplify(flat, faces, lossless=True)
    assert len(f) < 100 and np.abs(v[:, 2]).max() < 1e-6


def test_a_replay_gives_the_result_also_of_a_mesh_that_has_moved() -> None:
    points, faces = torus(60, 40)
    v, f, collapses = fast_simplification.simplify(points, faces, 0.8, return_collapses=True)
    again, triangles, numbers = fast_simplification.replay_simplification(points, faces, collapses)
    assert np.array_equal(again, v) and np.array_equal(triangles, f) and (edge_counts(f) == 2).all()
    assert np.array_equal(numbers[collapses[:, 1]], numbers[collapses[:, 0]]) and numbers.max() == len(v) - 1
    fitted = fast_simplification.simplify(points, faces, 0.8)[0]
    distances = [nm.compare((points, faces), (positions, f))["distance_mean"] or 0.0 for positions in (v, fitted)]
    assert distances[0] < 2 * distances[1]
    moved, triangles, _ = fast_simplification.replay_simplification(3 * points + 5, faces, collapses)
    assert np.array_equal(triangles, f) and np.allclose(moved, 3 * v + 5, atol=1e-6)
    # A merge after a merge; the fifth point has no triangle.
    square, two = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]), np.array([[0, 1, 2], [0, 2, 3]])
    v, f, numbers = fast_simplification.replay_simplification(square, two, [[1, 2], [0, 1]])
    assert (len(v), len(f)) == (2, 0) and list(numbers) == [0, 0, 0, 1, -1]
    with pytest.raises(ValueError, match="another mesh"):
        fast_simplification.replay_simplification(square, two, [[0, 4]])
    with pytest.raises(ValueError, match="in a circle"):
        fast_simplification.replay_simplification(square, two, [[0, 1], [1, 2], [2, 0]])


def test_replayed_borders_stay_where_they_are_kept() -> None:
    points, faces, _ = grid(20)
    v, f, collapses = fast_simplification.simplify(points, faces, 0.7, preserve_border=True, return_collapses=True)
    again, _, _ = fast_simplification.replay_simplification(points, faces, collapses, preserve_border=True)
    border = {tuple(point) for point in points if {0.0, 1.0} & set(point[:2])}
    assert np.array_equal(again, v) and (edge_counts(f) == 1).sum() == 80 and border <= {tuple(point) for point in v}


def test_pyfqmr() -> None:
    vertices, faces = torus(60, 40)
    mesh = pyfqmr.Simplify()
    mesh.setMesh(vertices, faces)
    mesh.simplify_mesh(target_count=500, aggressiveness=7, preserve_border=True, verbose=False)
    v, f, normals = mesh.getMesh()
    assert len(f) == 500 and v.dtype == np.float64 and normals.shape == f.shape
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    mesh.setMesh(vertices, faces)
    mesh.simplify_mesh_lossless(epsilon=0.01)
    assert 100 < len(mesh.getMesh()[1]) < len(faces)
    with pytest.raises(TypeError):
        mesh.setMesh(vertices, faces.astype(float))


def test_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*torus(60, 40), process=False)
    assert len(compat_trimesh.simplify_quadric_decimation(mesh, percent=0.75).faces) == 1200
    before = trimesh.Trimesh.simplify_quadric_decimation
    ours = list(inspect.signature(compat_trimesh.simplify_quadric_decimation).parameters)[1:]
    assert ours == list(inspect.signature(before).parameters)[1:]
    try:
        compat_trimesh.install()
        light = mesh.simplify_quadric_decimation(face_count=700, aggression=3)
        assert len(light.faces) == 700 and light.is_watertight
    finally:
        trimesh.Trimesh.simplify_quadric_decimation = before


def test_open3d() -> None:
    o3d = pytest.importorskip("open3d")
    vertices, faces = torus(60, 40, np.float64)
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    light = compat_open3d.simplify_quadric_decimation(mesh, 500)
    assert len(light.triangles) == 500 and light.is_watertight()
    assert len(compat_open3d.simplify_quadric_decimation(mesh, 100, maximum_error=0.01).triangles) > 100


def test_pyvista() -> None:
    pv = pytest.importorskip("pyvista")
    import neural_mesh.pyvista  # noqa: F401

    mesh = pv.PolyData.from_regular_faces(*torus(60, 40))
    light: Any = mesh.neural.simplify(faces=500)
    assert isinstance(light, pv.PolyData) and light.n_cells == 500
    assert [level.n_points for level in mesh.neural.lods([0.5, 0.1])] == [1200, 240]
    assert mesh.neural.compare(light)["distance_mean"] > 0
    assert fast_simplification.simplify_mesh(mesh, 0.5).n_cells == mesh.n_cells // 2

"""Results have the type and attributes of the input; packages that are not installed are skipped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import grid, torus


def split_grid(n: int) -> tuple[Any, Any, Any]:
    vertices, faces, uv = grid(n)
    rows, corner = np.unique(np.concatenate([vertices[faces].reshape(-1, 3), uv.reshape(-1, 2)], 1), axis=0, return_inverse=True)
    return rows[:, :3], corner.reshape(-1, 3), rows[:, 3:]


def assert_uv_fit(vertices: Any, faces: Any, corners: Any) -> None:
    chart = corners[..., :1] > 1.5
    assert np.abs(np.asarray(vertices)[faces][..., :2] + 2 * chart - corners).max() < 0.05


def test_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    vertices, faces, uv = split_grid(30)
    material = trimesh.visual.material.SimpleMaterial(diffuse=[10, 20, 30, 255])
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    mesh = trimesh.Trimesh(vertices, faces, process=False, visual=visual, metadata={"name": "grid"})
    light = nm.simplify(mesh, ratio=0.2)
    assert isinstance(light.mesh, trimesh.Trimesh) and len(light.mesh.faces) == len(light.faces)
    assert_uv_fit(light.mesh.vertices, light.mesh.faces, light.mesh.visual.uv[light.mesh.faces])
    assert light.mesh.visual.material is material and light.mesh.metadata["name"] == "grid"
    v, f = light
    assert len(v) == light.report["output"]["vertices"]


def test_trimesh_with_colours() -> None:
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = torus(40, 30)
    colours = np.concatenate([(vertices * 60 + 120).astype(np.uint8), np.full((len(vertices), 1), 255, np.uint8)], 1)
    light = nm.simplify(trimesh.Trimesh(vertices, faces, process=False, vertex_colors=colours), ratio=0.3)
    result = light.mesh
    assert result.is_watertight and result.visual.kind == "vertex"
    expected = result.vertices * 60 + 120
    assert np.abs(np.asarray(result.visual.vertex_colors)[:, :3] - expected).max() < 8
    halves = np.where((vertices[faces].mean(1)[:, 0] > 0)[:, None], [255, 0, 0, 255], [0, 255, 0, 255]).astype(np.uint8)
    light = nm.simplify(trimesh.Trimesh(vertices, faces, process=False, face_colors=halves), ratio=0.3)
    kinds = np.unique(np.asarray(light.mesh.visual.face_colors), axis=0)
    assert kinds.tolist() == [[0, 255, 0, 255], [255, 0, 0, 255]]


def test_open3d() -> None:
    o3d = pytest.importorskip("open3d")
    vertices, faces, uv = grid(30)
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    mesh.triangle_uvs = o3d.utility.Vector2dVector(uv.reshape(-1, 2))
    mesh.vertex_colors = o3d.utility.Vector3dVector(np.clip(np.abs(vertices), 0, 1))
    mesh.compute_vertex_normals()
    light = nm.simplify(mesh, ratio=0.2)
    result = light.mesh
    assert isinstance(result, o3d.geometry.TriangleMesh) and result.has_vertex_colors() and result.has_vertex_normals()
    corners = np.asarray(result.triangle_uvs).reshape(-1, 3, 2)
    assert_uv_fit(result.vertices, np.asarray(result.triangles), corners)
    lengths = np.linalg.norm(np.asarray(result.vertex_normals), axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-3)
    tensor = nm.simplify(o3d.t.geometry.TriangleMesh.from_legacy(mesh), ratio=0.2).mesh
    assert isinstance(tensor, o3d.t.geometry.TriangleMesh)


def test_pyvista() -> None:
    pv = pytest.importorskip("pyvista")
    vertices, faces, uv = split_grid(30)
    mesh = pv.PolyData.from_regular_faces(vertices, faces)
    mesh.active_texture_coordinates = uv.astype(np.float32)
    mesh.point_data["heat"] = vertices[:, 0]
    mesh.cell_data["part"] = (vertices[faces].mean(1)[:, 1] > 0.5).astype(int)
    light = nm.simplify(mesh, ratio=0.3)
    result = light.mesh
    assert isinstance(result, pv.PolyData) and set(result.cell_data["part"]) == {0, 1}
    assert_uv_fit(result.points, result.regular_faces, result.active_texture_coordinates[result.regular_faces])
    assert np.abs(result.point_data["heat"] - result.points[:, 0]).max() < 0.05


def test_array_likes() -> None:
    class Wrapped:
        def __init__(self, values: Any) -> None:
            self.values = values

        def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
            return np.asarray(self.values, dtype)

    class ByDlpack:
        def __init__(self, values: Any) -> None:
            self.values = values

        def __dlpack__(self, **options: Any) -> Any:
            return self.values.__dlpack__(**options)

        def __dlpack_device__(self) -> Any:
            return self.values.__dlpack_device__()

    vertices, faces = torus(30, 20)
    expected = nm.simplify((vertices, faces), ratio=0.3)
    for kind in (Wrapped, ByDlpack):
        light = nm.simplify((kind(vertices), kind(faces)), ratio=0.3)
        np.testing.assert_array_equal(light.vertices, expected.vertices)


def test_objects_with_vertices_and_faces() -> None:
    class Mesh:
        vertices, faces = torus(30, 20)

    light = nm.simplify(Mesh(), ratio=0.3)
    v, f = light.mesh
    assert len(v) == 180 and f is light.faces

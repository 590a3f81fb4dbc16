"""Tests of the ComfyUI node, with ComfyUI's MESH type if NEURAL_MESH_COMFYUI names `geometry_types.py`, else a class of equal fields."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
from conftest import grid, torus  # noqa: E402

FOLDER = Path(__file__).resolve().parents[1] / "comfyui"


class Mesh:
    """Stand-in for MESH with the fields that the node uses."""

    def __init__(self, vertices: Any, faces: Any, uvs: Any = None, vertex_colors: Any = None, texture: Any = None, **more: Any) -> None:
        self.vertices, self.faces, self.uvs, self.vertex_colors, self.texture = vertices, faces, uvs, vertex_colors, texture
        self.vertex_counts, self.face_counts = more.get("vertex_counts"), more.get("face_counts")
        self.normals = self.tangents = None


class OldMesh:
    """Stand-in for the first version of MESH, without attributes."""

    def __init__(self, vertices: Any, faces: Any) -> None:
        self.vertices, self.faces = vertices, faces


def load_module(name: str, path: Path, folder: Path | None = None) -> Any:
    locations = [str(folder)] if folder else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=locations)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def node() -> Any:
    package = load_module("comfyui_neural_mesh", FOLDER / "__init__.py", FOLDER)
    (one,) = package.NODE_CLASS_MAPPINGS.values()
    assert set(package.NODE_CLASS_MAPPINGS) == set(package.NODE_DISPLAY_NAME_MAPPINGS)
    return one()


@pytest.fixture(scope="module")
def mesh_type() -> Any:
    source = os.environ.get("NEURAL_MESH_COMFYUI")
    return load_module("comfyui_geometry_types", Path(source)).MESH if source else Mesh


def test_node_carries_texture_coordinates_and_colours(node: Any, mesh_type: Any) -> None:
    vertices, faces, uv = grid(30)
    rows, corner = np.unique(np.concatenate([vertices[faces].reshape(-1, 3), uv.reshape(-1, 2)], 1), axis=0, return_inverse=True)
    tensor = torch.from_numpy(rows).float()
    texture = torch.zeros(1, 8, 8, 3)
    colours = tensor[None, :, :3].abs().clamp(0, 1)
    mesh = mesh_type(tensor[None, :, :3], torch.from_numpy(corner.reshape(1, -1, 3)), uvs=tensor[None, :, 3:], vertex_colors=colours, texture=texture)
    (light,) = node.simplify(mesh, faces=400, ratio=0.5)
    assert type(light) is mesh_type and light.texture is texture and light.vertex_counts is None
    assert light.faces.shape[1] in (399, 400) and light.faces.dtype == torch.int64
    assert light.uvs.shape == (*light.vertices.shape[:2], 2)
    chart = (light.uvs[0, :, :1] > 1.5).float()
    assert (light.vertices[0, :, :2] + 2 * chart - light.uvs[0]).abs().max() < 0.05
    assert (light.vertex_colors[0] - light.vertices[0].abs().clamp(0, 1)).abs().max() < 0.05
    # The input is unchanged.
    assert len(mesh.faces[0]) == 1800


def test_batch_of_different_sizes(node: Any, mesh_type: Any) -> None:
    meshes = [torus(40, 30), torus(20, 12)]
    counts = [torch.tensor([len(pair[at]) for pair in meshes]) for at in (0, 1)]
    vertices, faces = (
        torch.nn.utils.rnn.pad_sequence([torch.from_numpy(pair[at]) for pair in meshes], batch_first=True) for at in (0, 1)
    )
    (light,) = node.simplify(mesh_type(vertices, faces, vertex_counts=counts[0], face_counts=counts[1]), faces=0, ratio=0.25)
    assert light.vertex_counts.tolist() == [300, 60] and light.face_counts.tolist() == [600, 120]
    assert light.vertices.shape == (2, 300, 3) and (light.faces[1, 120:] == 0).all()


def test_first_version_of_mesh(node: Any) -> None:
    vertices, faces = (torch.from_numpy(array)[None] for array in torus(40, 30))
    (light,) = node.simplify(OldMesh(vertices, faces), faces=500, ratio=1.0, optimize="mean", seed=3)
    assert light.faces.shape == (1, 500, 3) and vars(light).keys() == {"vertices", "faces"}
    both = OldMesh(torch.cat([vertices, vertices * 2]), torch.cat([faces, faces]))
    assert node.simplify(both, faces=500, ratio=1.0)[0].faces.shape == (2, 500, 3)


def test_menu_matches_options_of_simplify(node: Any) -> None:
    inputs = node.INPUT_TYPES()
    offered = {**inputs["required"], **inputs["optional"]}
    defaults = {name: kind[1]["default"] for name, kind in offered.items() if name != "mesh"}
    vertices, faces = (torch.from_numpy(array)[None] for array in torus(40, 30))
    (light,) = node.simplify(OldMesh(vertices, faces), **defaults)
    assert light.faces.shape == faces.shape
    with pytest.raises(nm.NeuralMeshError):
        node.simplify(OldMesh(vertices, faces[:, :0]), **defaults)

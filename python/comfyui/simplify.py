"""The node, over ComfyUI's MESH: batches of vertices (B, N, 3) and faces (B, M, 3), padded with zeros where lengths differ.

What is a vertex's (`uvs`, `vertex_colors`, `normals`, `tangents`) is simplified along; textures and materials stay as they are.
"""

from __future__ import annotations

import copy
from typing import Any

import neural_mesh as nm
import torch

# What a MESH has of its vertices, and what it is called here. Older ones have none of it.
_OF_VERTICES = {"uvs": "uv", "vertex_colors": "colors", "normals": "normals", "tangents": "tangents"}


class SimplifyMesh:
    """Makes each mesh of a batch lighter."""

    CATEGORY = "3d"
    FUNCTION = "simplify"
    RETURN_TYPES = ("MESH",)
    DESCRIPTION = "Reduces the vertices of a mesh. A closed mesh stays closed; texture coordinates and colours are kept."

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        return {
            "required": {
                "mesh": ("MESH",),
                "faces": ("INT", {"default": 50_000, "min": 0, "max": 100_000_000, "tooltip": "Number of faces to keep; 0 uses the ratio."}),
                "ratio": ("FLOAT", {"default": 0.1, "min": 0.0001, "max": 1.0, "step": 0.01, "tooltip": "Share of the vertices to keep, if faces is 0."}),
            },
            "optional": {
                "optimize": (["balanced", "mean", "max", "normals"], {"default": "balanced"}),
                "fill_holes": ("BOOLEAN", {"default": False, "tooltip": "Close holes first."}),
                "printable": ("BOOLEAN", {"default": False, "tooltip": "Make a printable solid first."}),
                "lock_boundaries": ("BOOLEAN", {"default": False, "tooltip": "Keep the boundary exactly."}),
                "keep_components": ("BOOLEAN", {"default": False, "tooltip": "Keep all components, also small ones."}),
                "seed": ("INT", {"default": 0, "min": 0, "max": 0xFFFFFFFF}),
            },
        }

    def simplify(self, mesh: Any, faces: int, ratio: float, **options: Any) -> tuple[Any]:
        """The batch with each mesh at the size asked for; one that is no larger stays."""
        size: dict[str, Any] = {"faces": faces} if faces > 0 else {"ratio": ratio}
        return (_batch(mesh, [_lighter(item, size, options) for item in _items(mesh)]),)


def _items(mesh: Any) -> list[dict[str, Any]]:
    """The meshes of a batch, each as its tensors without padding."""
    items = []
    n_vertices, n_faces = (getattr(mesh, name, None) for name in ("vertex_counts", "face_counts"))
    for at in range(len(mesh.vertices)):
        vertices = slice(None) if n_vertices is None else slice(int(n_vertices[at]))
        item = {"vertices": mesh.vertices[at][vertices]}
        item["faces"] = mesh.faces[at][slice(None) if n_faces is None else slice(int(n_faces[at]))]
        for name in _OF_VERTICES:
            if getattr(mesh, name, None) is not None:
                item[name] = getattr(mesh, name)[at][vertices]
        items.append(item)
    return items


def _lighter(item: dict[str, Any], size: dict[str, Any], options: dict[str, Any]) -> dict[str, Any]:
    attributes = {called: item[name] for name, called in _OF_VERTICES.items() if name in item}
    light = nm.simplify((item["vertices"], item["faces"].long()), attributes=attributes, **size, **options)
    vertices, faces, values = light.split()
    lighter = {"vertices": vertices, "faces": faces, **{name: values[called] for name, called in _OF_VERTICES.items() if called in values}}
    return {name: torch.from_numpy(array).to(item[name].device, item[name].dtype) for name, array in lighter.items()}


def _batch(mesh: Any, items: list[dict[str, Any]]) -> Any:
    """A MESH like the one given, of these meshes."""
    result = copy.copy(mesh)
    for name in items[0]:
        setattr(result, name, torch.nn.utils.rnn.pad_sequence([item[name] for item in items], batch_first=True))
    lengths = {name: torch.tensor([len(item[name]) for item in items]) for name in ("vertices", "faces")}
    is_uneven = any(len(set(lengths[name].tolist())) > 1 for name in lengths)
    if is_uneven and not hasattr(mesh, "vertex_counts"):
        raise nm.NeuralMeshError("meshes of a batch get different sizes, which this ComfyUI cannot store: give one mesh at a time")
    if hasattr(mesh, "vertex_counts"):
        result.vertex_counts, result.face_counts = (lengths["vertices"], lengths["faces"]) if is_uneven else (None, None)
    return result

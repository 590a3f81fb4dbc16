"""Implements the node on ComfyUI's MESH: batches of vertices (B, N, 3) and faces (B, M, 3), padded with zeros.

Vertex attributes (`uvs`, `vertex_colors`, `normals`, `tangents`) are carried; textures and materials stay unchanged.
"""

from __future__ import annotations

import copy
from typing import Any

import neural_mesh as nm
import torch

# Vertex attributes of a MESH, with their names in neural_mesh. Older versions of MESH have none.
_ATTRIBUTES = {"uvs": "uv", "vertex_colors": "colors", "normals": "normals", "tangents": "tangents"}


class SimplifyMesh:
    """The node that simplifies each mesh of a batch."""

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
                "optimize": (["balanced", "mean", "max", "normals", "looks"], {"default": "balanced"}),
                "fill_holes": ("BOOLEAN", {"default": False, "tooltip": "Close holes first."}),
                "printable": ("BOOLEAN", {"default": False, "tooltip": "Make a printable solid first."}),
                "lock_boundaries": ("BOOLEAN", {"default": False, "tooltip": "Keep the boundary exactly."}),
                "keep_components": ("BOOLEAN", {"default": False, "tooltip": "Keep all components, also small ones."}),
                "seed": ("INT", {"default": 0, "min": 0, "max": 0xFFFFFFFF}),
            },
        }

    def simplify(self, mesh: Any, faces: int, ratio: float, **options: Any) -> tuple[Any]:
        """Simplifies each mesh of the batch to the requested size; smaller meshes stay unchanged."""
        size: dict[str, Any] = {"faces": faces} if faces > 0 else {"ratio": ratio}
        return (_make_batch(mesh, [_simplify_item(item, size, options) for item in _split_batch(mesh)]),)


def _split_batch(mesh: Any) -> list[dict[str, Any]]:
    """Splits a batch into meshes, each a dictionary of tensors without padding."""
    items = []
    n_vertices, n_faces = (getattr(mesh, name, None) for name in ("vertex_counts", "face_counts"))
    for at in range(len(mesh.vertices)):
        vertices = slice(None) if n_vertices is None else slice(int(n_vertices[at]))
        item = {"vertices": mesh.vertices[at][vertices]}
        item["faces"] = mesh.faces[at][slice(None) if n_faces is None else slice(int(n_faces[at]))]
        for name in _ATTRIBUTES:
            if getattr(mesh, name, None) is not None:
                item[name] = getattr(mesh, name)[at][vertices]
        items.append(item)
    return items


def _simplify_item(item: dict[str, Any], size: dict[str, Any], options: dict[str, Any]) -> dict[str, Any]:
    attributes = {attribute: item[name] for name, attribute in _ATTRIBUTES.items() if name in item}
    light = nm.simplify((item["vertices"], item["faces"].long()), attributes=attributes, **size, **options)
    vertices, faces, values = light.split()
    lighter = {"vertices": vertices, "faces": faces, **{name: values[attribute] for name, attribute in _ATTRIBUTES.items() if attribute in values}}
    return {name: torch.from_numpy(array).to(item[name].device, item[name].dtype) for name, array in lighter.items()}


def _make_batch(mesh: Any, items: list[dict[str, Any]]) -> Any:
    """Returns a copy of a MESH that holds these meshes."""
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

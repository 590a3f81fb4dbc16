"""Replaces `simplify_quadric_decimation` of trimesh: as a function, or after `install` as the method of all meshes."""

from __future__ import annotations

from typing import Any

from .. import simplify as _simplify
from ._sizes import QUIET, target_faces

__all__ = ["install", "simplify_quadric_decimation"]


def simplify_quadric_decimation(mesh: Any, percent: float | None = None, face_count: int | None = None, aggression: int | None = None) -> Any:
    """Simplifies a mesh: `percent` is the share of faces to remove (0 to 1), `face_count` the number to keep.

    Unlike the original, it carries texture coordinates, colours and vertex attributes. `aggression` has no effect."""
    n_faces = target_faces(len(mesh.faces), percent, face_count)
    return _simplify(mesh, faces=max(n_faces, 1), **QUIET).mesh


def install() -> None:
    """Replaces the method of `trimesh.Trimesh` by this function."""
    import trimesh

    trimesh.Trimesh.simplify_quadric_decimation = simplify_quadric_decimation

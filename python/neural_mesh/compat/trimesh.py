"""`simplify_quadric_decimation` of trimesh: as a function of a mesh, or as the method of all meshes after `install`."""

from __future__ import annotations

from typing import Any

from .. import simplify as _simplify
from ._sizes import QUIET, faces_of

__all__ = ["install", "simplify_quadric_decimation"]


def simplify_quadric_decimation(mesh: Any, percent: float | None = None, face_count: int | None = None, aggression: int | None = None) -> Any:
    """The mesh without `percent` (0 to 1) of its faces, or with `face_count` of them. Texture coordinates, colours and attributes of
    vertices come along, which they do not there. `aggression` is a speed there and nothing here."""
    n_faces = faces_of(len(mesh.faces), percent, face_count)
    return _simplify(mesh, faces=max(n_faces, 1), **QUIET).mesh


def install() -> None:
    """Makes it the method of `trimesh.Trimesh`."""
    import trimesh

    trimesh.Trimesh.simplify_quadric_decimation = simplify_quadric_decimation

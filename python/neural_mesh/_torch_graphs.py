"""What the stages of the network look along, and at, as tensors: edges, graphs, candidate faces, normals, the unit of length.

Indices are rows of whole numbers, in and out (int64). All but `in_edge_lengths` are constants: no gradient goes through them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch

from . import _native
from ._native import NeuralMeshError
from ._torch_arrays import as_numpy


class CandidateFaces(NamedTuple):
    """Triangles that the Face Classifier judges, near ones near each other."""

    faces: Any
    """Corners, ascending: n_candidates x 3."""
    entries: Any
    """Where the edges ij, ik, jk of each stand among the entries of the graph: n_candidates x 3."""


def edges_of_faces(faces: Any) -> Any:
    """The edges of a mesh (faces n_faces x 3), each once: n_edges x 2, int64."""
    corners = _rows(faces, 3, "faces").long()
    sides = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return torch.unique(sides.sort(1).values, dim=0)


def vertex_normals(vertices: Any, faces: Any) -> Any:
    """Unit normals at the vertices (n x 3) of a mesh (faces n_faces x 3), n x 3: the direction of the sum of the area normals around
    each, zero where there is none."""
    normals = _native.vertex_normals(as_numpy(point_rows(vertices, "vertices"), torch.float32), face_rows(faces))
    return torch.from_numpy(normals).to(vertices.device, vertices.dtype)


def in_edge_lengths(points: Any, edges: Any) -> Any:
    """Points n x 3 about their mean, in units of the mean length of `edges` (n_edges x 2): what the network measures in, in place of
    the paper's unit box (docs/paper.md). Differentiable."""
    a, b = _rows(edges, 2, "edges").long().unbind(1)
    points = point_rows(points, "points")
    length = (points[a] - points[b]).norm(dim=1).sum() / max(len(a), 1)
    return (points - points.mean(0)) / torch.where(length > 0, length, torch.ones_like(length))


def extended_graph(points: Any, edges: Any, knn: int = 15) -> Any:
    """The entries of G_ext, Sec. 3.2: `edges` (n_edges x 2), the `knn` nearest of each point (n x 3), and each point with itself;
    both directions, row by row, columns ascending: n_entries x 2."""
    given = as_numpy(point_rows(points, "points"), torch.float32)
    return _indices(_native.extended_graph(given, edge_rows(edges), _count(knn), torch.get_num_threads()), points)


def triangle_graph(points: Any, faces: Any, knn: int = 20) -> Any:
    """The entries of G_tri, Sec. 3.3: each face (n_faces x 3) with the `knn` others whose barycenters are nearest, or with those that
    share an edge with it where `knn` is 0; row by row, columns ascending: n_entries x 2."""
    given = as_numpy(point_rows(points, "points"), torch.float32)
    return _indices(_native.triangle_graph(given, face_rows(faces), _count(knn), torch.get_num_threads()), points)


def candidate_faces(points: Any, graph: Any, adjacency: Any, surface: Any = None, per_point: int = 0) -> CandidateFaces:
    """The triangles of `graph` whose three edges have a positive adjacency, Sec. 3.2, and always those of `surface`.

    points: n x 3
    graph: n_entries x 2, as `extended_graph` gives them
    adjacency: n_entries, A_s of Eq. (3)
    surface: n_surface x 3, triangles that the mesh has between samples, their edges in the graph; none where not given
    per_point: keeps so many candidates for each point, those with the largest prior, and those of `surface`; 0 keeps all
    """
    surface = torch.empty((0, 3), dtype=torch.int64) if surface is None else surface
    if adjacency.dim() != 1:
        raise NeuralMeshError(f"adjacency: a tensor of shape {tuple(adjacency.shape)}: give a number for each entry")
    given = (as_numpy(point_rows(points, "points"), torch.float32), edge_rows(graph, "graph"), as_numpy(adjacency, torch.float32))
    found = _native.candidate_faces(*given, face_rows(surface, "surface"), _count(per_point), torch.get_num_threads())
    return CandidateFaces(*(_indices(array, points) for array in found))


def point_rows(points: Any, what: str) -> Any:
    """Points as they are, if they are."""
    if points.dim() != 2 or points.shape[1] != 3 or not points.is_floating_point():
        raise NeuralMeshError(f"{what}: a tensor of shape {tuple(points.shape)}, {points.dtype}: give n x 3 floating-point numbers")
    return points


def edge_rows(edges: Any, what: str = "edges") -> Any:
    """Pairs of indices as an array."""
    return as_numpy(_rows(edges, 2, what), torch.int64)


def face_rows(faces: Any, what: str = "faces") -> Any:
    """Triples of indices as an array."""
    return as_numpy(_rows(faces, 3, what), torch.int64)


def _rows(indices: Any, n_columns: int, what: str) -> Any:
    if indices.dim() != 2 or indices.shape[1] != n_columns or indices.is_floating_point() or indices.is_complex():
        found = f"a tensor of shape {tuple(indices.shape)}, {indices.dtype}"
        raise NeuralMeshError(f"{what}: {found}: give n x {n_columns} whole numbers")
    return indices


def _indices(array: Any, like: Any) -> Any:
    return torch.from_numpy(array.astype(np.int64)).to(like.device)


def _count(knn: int) -> int:
    if knn < 0:
        raise NeuralMeshError(f"knn: {knn}: give at least 0")
    return knn

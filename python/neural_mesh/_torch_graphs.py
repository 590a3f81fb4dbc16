"""Inputs of the network's stages as tensors: edges, graphs, candidate faces, normals and positions in edge lengths.

Indices are int64. No gradient passes through these functions, except through `in_edge_lengths`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch

from . import _native
from ._native import NeuralMeshError
from ._torch_arrays import as_numpy


class CandidateFaces(NamedTuple):
    """Triangles for the Face Classifier, ordered so that neighbors in space are close in the list."""

    faces: Any
    """Corners in ascending order, n_candidates x 3."""
    entries: Any
    """Graph entries of the edges ij, ik and jk of each face, n_candidates x 3."""


def edges_of_faces(faces: Any) -> Any:
    """Returns the edges of a mesh (faces n_faces x 3), each once: n_edges x 2, int64."""
    corners = _check_rows(faces, 3, "faces").long()
    sides = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return torch.unique(sides.sort(1).values, dim=0)


def vertex_normals(vertices: Any, faces: Any) -> Any:
    """Returns area-weighted unit normals at the vertices, n x 3; zero where the normals of the faces cancel.

    `vertices` is n x 3, `faces` n_faces x 3."""
    normals = _native.vertex_normals(as_numpy(point_rows(vertices, "vertices"), torch.float32), face_rows(faces))
    return torch.from_numpy(normals).to(vertices.device, vertices.dtype)


def in_edge_lengths(points: Any, edges: Any) -> Any:
    """Centers points (n x 3) and scales them to the mean length of `edges` (n_edges x 2); differentiable.

    The network measures in this unit instead of the paper's unit box (docs/paper.md)."""
    a, b = _check_rows(edges, 2, "edges").long().unbind(1)
    points = point_rows(points, "points")
    length = (points[a] - points[b]).norm(dim=1).sum() / max(len(a), 1)
    return (points - points.mean(0)) / torch.where(length > 0, length, torch.ones_like(length))


def extended_graph(points: Any, edges: Any, knn: int = 15) -> Any:
    """Returns the entries of G_ext, Sec. 3.2: the edges, the `knn` nearest neighbors of each point, and the points themselves.

    `points` is n x 3, `edges` n_edges x 2. Entries are n_entries x 2, both directions, sorted by row, then column."""
    arrays = as_numpy(point_rows(points, "points"), torch.float32)
    return _index_tensor(_native.extended_graph(arrays, edge_rows(edges), _check_count(knn), torch.get_num_threads()), points)


def triangle_graph(points: Any, faces: Any, knn: int = 20) -> Any:
    """Returns the entries of G_tri, Sec. 3.3: each face (n_faces x 3) with the `knn` others of nearest barycenters.

    With `knn` 0, a face is joined with the faces that share an edge with it. Entries are n_entries x 2, sorted by row, then column."""
    arrays = as_numpy(point_rows(points, "points"), torch.float32)
    return _index_tensor(_native.triangle_graph(arrays, face_rows(faces), _check_count(knn), torch.get_num_threads()), points)


def candidate_faces(points: Any, graph: Any, adjacency: Any, surface: Any = None, per_point: int = 0) -> CandidateFaces:
    """Returns the triangles of `graph` whose three edges have a positive adjacency, Sec. 3.2, and all of `surface`.

    points: n x 3
    graph: n_entries x 2, from `extended_graph`
    adjacency: n_entries, A_s of Eq. (3)
    surface: n_surface x 3, triangles of the mesh between samples, their edges in the graph; none by default
    per_point: candidates per point to keep besides `surface`, those with the largest prior; 0 keeps all
    """
    surface = torch.empty((0, 3), dtype=torch.int64) if surface is None else surface
    if adjacency.dim() != 1:
        raise NeuralMeshError(f"adjacency: a tensor of shape {tuple(adjacency.shape)}: give a number for each entry")
    arrays = (as_numpy(point_rows(points, "points"), torch.float32), edge_rows(graph, "graph"), as_numpy(adjacency, torch.float32))
    found = _native.candidate_faces(*arrays, face_rows(surface, "surface"), _check_count(per_point), torch.get_num_threads())
    return CandidateFaces(*(_index_tensor(array, points) for array in found))


def point_rows(points: Any, name: str) -> Any:
    """Returns the points after checking that they are floating-point and n x 3."""
    if points.dim() != 2 or points.shape[1] != 3 or not points.is_floating_point():
        raise NeuralMeshError(f"{name}: a tensor of shape {tuple(points.shape)}, {points.dtype}: give n x 3 floating-point numbers")
    return points


def edge_rows(edges: Any, name: str = "edges") -> Any:
    """Returns pairs of indices as a checked int64 array, n x 2."""
    return as_numpy(_check_rows(edges, 2, name), torch.int64)


def face_rows(faces: Any, name: str = "faces") -> Any:
    """Returns triples of indices as a checked int64 array, n x 3."""
    return as_numpy(_check_rows(faces, 3, name), torch.int64)


def _check_rows(indices: Any, n_columns: int, name: str) -> Any:
    if indices.dim() != 2 or indices.shape[1] != n_columns or indices.is_floating_point() or indices.is_complex():
        found = f"a tensor of shape {tuple(indices.shape)}, {indices.dtype}"
        raise NeuralMeshError(f"{name}: {found}: give n x {n_columns} whole numbers")
    return indices


def _index_tensor(array: Any, like: Any) -> Any:
    return torch.from_numpy(array.astype(np.int64)).to(like.device)


def _check_count(knn: int) -> int:
    if knn < 0:
        raise NeuralMeshError(f"knn: {knn}: give at least 0")
    return knn

"""Graphs and candidate faces of the network (docs/paper.md, Secs. 3.2 and 3.3) in PyTorch's operators.

Graphs are `[2, n_entries]`: rows above columns, both directions of each edge, sorted by row, then column. Indices are int64. Meshes of
a batch are packed: `batch` has the mesh of each vertex, ascending. No gradient passes through these functions, except
`in_edge_lengths` and `vertex_normals`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from .._native import NeuralMeshError
from ._nearest import nearest_neighbours
from ._segments import entries_of, expand_ranges, find_sorted, row_starts, sum_by, wide


class Product(NamedTuple):
    """Terms of Eq. (3): `T = S A` has a slot for each entry of `T` that counts, and `A_s[i, j]` sums `T[i, l] S[j, l]`."""

    slots: Any
    """Keys `i * n + l` of the slots of T, ascending: n_slots."""
    parts: Any
    """Entries (i, k) of S whose value is added to a slot, and that slot: 2 x n_parts."""
    terms: Any
    """Entries (i, j) with i <= j, slots (i, l) and entries (j, l) of each product: 3 x n_terms."""
    mirror: Any
    """The entry (min, max) of each entry's pair: n_entries."""


class CandidateFaces(NamedTuple):
    """Triangles for the Face Classifier, in lexicographic order."""

    faces: Any
    """Corners in ascending order, n_candidates x 3."""
    entries: Any
    """Graph entries of the edges ij, ik and jk of each face, n_candidates x 3."""


def mesh_graph(faces: Any, n_vertices: int) -> Any:
    """Returns the graph of a mesh's edges: `[2, n_entries]`.

    `faces` is n_faces x 3."""
    a, b = faces[:, [0, 1, 2]].reshape(-1), faces[:, [1, 2, 0]].reshape(-1)
    keys = torch.cat([a * n_vertices + b, b * n_vertices + a])
    return entries_of(keys[torch.cat([a != b, a != b])], n_vertices)


def vertex_normals(vertices: Any, faces: Any) -> Any:
    """Returns area-weighted unit normals at the vertices, n x 3; zero where the normals of the faces cancel."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = torch.linalg.cross(b - a, c - a)
    sums = torch.zeros_like(vertices)
    for corner in range(3):
        sums = sums.index_add(0, faces[:, corner], normals)
    length = sums.square().sum(1, keepdim=True)
    return sums * torch.where(length > 0, length, 1).rsqrt()


def in_edge_lengths(points: Any, graph: Any, batch: Any = None, n_meshes: int = 1) -> Any:
    """Centers the points of each mesh and scales them to mean edge length 1, n x 3; differentiable.

    The network measures in this unit instead of the paper's unit box (docs/paper.md)."""
    center, scale = edge_frame(points, graph, batch, n_meshes)
    index = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    return ((wide(points) - center[index]) * scale[index, None]).to(points.dtype)


def edge_frame(points: Any, graph: Any, batch: Any = None, n_meshes: int = 1) -> tuple[Any, Any]:
    """Returns the center (n_meshes x 3) and the factor to mean edge length 1 (n_meshes) of each mesh, in double precision."""
    rows, cols = graph[:, graph[0] < graph[1]]
    batch = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    points = wide(points)
    counts = sum_by(torch.ones_like(points[:, 0]), batch, n_meshes)
    center = sum_by(points, batch, n_meshes) / counts.clamp(min=1)[:, None]
    edges = (points[rows] - points[cols]).norm(dim=1)
    sums, n_edges = (sum_by(x, batch[rows], n_meshes) for x in (edges, torch.ones_like(edges)))
    return center, torch.where(sums > 0, n_edges / torch.where(sums > 0, sums, 1), 1)


def extended_graph(points: Any, edges: Any, knn: int = 15, batch: Any = None) -> Any:
    """Returns G_ext, Sec. 3.2: the edges, the `knn` nearest neighbors of each point, and the points themselves.

    `points` is n x 3, `edges` the graph between samples that the mesh joins."""
    n = len(points)
    nearest = nearest_neighbours(points, knn, batch)
    own = torch.arange(n, device=points.device)
    rows, cols = own[:, None].expand_as(nearest)[nearest >= 0], nearest[nearest >= 0]
    return entries_of(torch.cat([rows * n + cols, cols * n + rows, own * n + own, edges[0] * n + edges[1]]), n)


def product_terms(graph: Any, adjacency: Any, n: int) -> Product:
    """Lists the terms of `A_s = S A S^T` on the entries of `graph`, with A the graph `adjacency` over the same n nodes."""
    rows, cols = graph
    keys = rows * n + cols
    mirror = torch.searchsorted(keys, torch.minimum(rows, cols) * n + torch.maximum(rows, cols))
    starts = row_starts(adjacency[0], n)
    owner, at = expand_ranges(starts[cols], (starts[1:] - starts[:-1])[cols])
    slots, slot_of = torch.unique(rows[owner] * n + adjacency[1][at], return_inverse=True)
    upper = (rows <= cols).nonzero()[:, 0]
    starts = row_starts(rows, n)
    which, others = expand_ranges(starts[cols[upper]], (starts[1:] - starts[:-1])[cols[upper]])
    entries = upper[which]
    places, is_there = find_sorted(slots, rows[entries] * n + cols[others])
    terms = torch.stack([entries[is_there], places[is_there], others[is_there]])
    return Product(slots, torch.stack([owner, slot_of]), terms, mirror)


def candidate_faces(graph: Any, adjacency: Any, surface: Any = None, per_point: int = 0, batch: Any = None, n: int = 0) -> CandidateFaces:
    """Returns the triangles of `graph` whose three edges have a positive adjacency, Sec. 3.2, and all of `surface`.

    graph: G_ext
    adjacency: n_entries, A_s of Eq. (3)
    surface: n_surface x 3, triangles of the mesh between samples, ascending, their edges in the graph; none by default
    per_point: candidates per point to keep besides `surface`, those with the largest prior; 0 keeps all
    batch: mesh of each point
    n: number of points; one more than the largest in the graph by default
    """
    rows, cols = graph
    n = n or (int(rows[-1]) + 1 if len(rows) else 0)
    if n >= 1 << 21:
        raise NeuralMeshError(f"graph: {n} samples: at most {(1 << 21) - 1} fit: give fewer, or smaller batches")
    adjacency = adjacency.detach()
    keys = rows * n + cols
    upper = (rows < cols).nonzero()[:, 0]
    ends = row_starts(rows, n)[1:]
    which, ik = expand_ranges(upper + 1, ends[rows[upper]] - upper - 1)
    ij = upper[which]
    jk, is_closed = find_sorted(keys, cols[ij] * n + cols[ik])
    ij, ik, jk = ij[is_closed], ik[is_closed], jk[is_closed]
    is_predicted = (adjacency[ij] > 0) & (adjacency[ik] > 0) & (adjacency[jk] > 0)
    is_surface = torch.zeros_like(is_predicted)
    if surface is not None and len(surface) > 0:
        is_surface = find_sorted(_triangle_keys(surface, n), (rows[ij] * n + cols[ij]) * n + cols[ik])[1]
    kept = is_predicted | is_surface
    entries, is_surface = torch.stack([ij, ik, jk], 1)[kept], is_surface[kept]
    if per_point > 0:
        entries = entries[is_surface | _have_largest_prior(entries, adjacency, rows, per_point, batch, n)]
    return CandidateFaces(torch.stack([rows[entries[:, 0]], cols[entries[:, 0]], cols[entries[:, 1]]], 1), entries)


def _triangle_keys(faces: Any, n: int) -> Any:
    return (faces[:, 0] * n + faces[:, 1]) * n + faces[:, 2]


def is_among(faces: Any, surface: Any, n: int) -> Any:
    """Returns for each face (ascending corners below n) whether it is one of `surface`, sorted and ascending."""
    return find_sorted(_triangle_keys(surface, n), _triangle_keys(faces, n))[1]


def unite_triangles(some: Any, others: Any, n: int) -> Any:
    """Returns the triangles of both lists (ascending corners below n), sorted, each once."""
    keys = torch.unique(_triangle_keys(torch.cat([some, others]), n))
    first = torch.div(keys, n, rounding_mode="floor")
    return torch.stack([torch.div(first, n, rounding_mode="floor"), first % n, keys % n], 1)


def _have_largest_prior(entries: Any, adjacency: Any, rows: Any, per_point: int, batch: Any, n: int) -> Any:
    """Marks the candidates of largest prior, `per_point` times the points of each mesh; the first of equal ones."""
    prior = adjacency[entries[:, 0]] + adjacency[entries[:, 1]] + adjacency[entries[:, 2]]
    order = prior.argsort(descending=True, stable=True)
    if batch is None:
        return torch.zeros_like(prior, dtype=torch.bool).index_fill(0, order[: per_point * n], True)
    mesh = batch[rows[entries[:, 0]]]
    order = order[mesh[order].argsort(stable=True)]
    mesh = mesh[order]
    starts = row_starts(mesh, int(batch[-1]) + 1)
    rank = torch.arange(len(order), device=order.device) - starts[mesh]
    return torch.zeros_like(rank, dtype=torch.bool).index_put((order,), rank < per_point * torch.bincount(batch)[mesh])


def triangle_graph(points: Any, faces: Any, knn: int = 20, batch: Any = None) -> Any:
    """Returns G_tri, Sec. 3.3: each face (n_faces x 3) with the `knn` others of nearest barycenters; rows need not be symmetric.

    With `knn` 0, a face is joined with the faces that share an edge with it. `batch` is the mesh of each point."""
    if knn == 0:
        sides = faces[:, [0, 1, 0, 2, 1, 2]].reshape(-1, 2).sort(1).values
        _, edges = torch.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
        return join_across_edges(edges.reshape(-1, 3))
    centers = points.detach()[faces].mean(1)
    if batch is None:
        nearest = nearest_neighbours(centers, knn)
    else:
        mesh = batch[faces[:, 0]]
        order = mesh.argsort(stable=True)
        rows = nearest_neighbours(centers[order], knn, mesh[order])
        nearest = torch.empty_like(rows).index_copy(0, order, torch.where(rows >= 0, order[rows.clamp(min=0)], -1))
    own = torch.arange(len(faces), device=faces.device)[:, None].expand_as(nearest)
    return entries_of((own * len(faces) + nearest)[nearest >= 0], len(faces))


def join_across_edges(edges: Any) -> Any:
    """Joins faces that share an edge, by the numbers of each face's edges (n_faces x 3)."""
    n = len(edges)
    numbers, places = edges.reshape(-1).sort(stable=True)
    _, group, counts = torch.unique_consecutive(numbers, return_inverse=True, return_counts=True)
    faces = torch.div(places, 3, rounding_mode="floor")
    starts = counts.cumsum(0) - counts
    owner, at = expand_ranges(starts[group], counts[group])
    rows, cols = faces[owner], faces[at]
    keys = (rows * n + cols)[rows != cols].sort().values
    return torch.stack([torch.div(keys, max(n, 1), rounding_mode="floor"), keys % max(n, 1)])

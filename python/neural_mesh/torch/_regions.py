"""Regions of the samples on the surface, the edges and triangles between them, and pooling over them."""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from ._segments import entries_of, find_sorted, most_by, wide

_FAR = 1 << 62


class Quotient(NamedTuple):
    """Edges, triangles and normals between the regions of the samples."""

    edges: Any
    """Graph of regions joined by an edge of the mesh, `[2, n_entries]`."""
    triangles: Any
    """Triangles that faces of the mesh span between three regions, ascending, sorted: n_triangles x 3."""
    windings: Any
    """Faces of the mesh wound like the ascending corners of each triangle, less those wound against them: n_triangles."""
    normals: Any
    """Sums of the area normals of the faces at each region, n_samples x 3, double."""


def assign_to_samples(points: Any, graph: Any, samples: Any) -> Any:
    """Finds for every vertex (points n x 3) the nearest sample along the edges: indices into `samples`, n; -1 where none is reached.

    Distances are relaxed along all edges until none shrinks. A vertex belongs to the first sample from which a path of edges leads
    whose lengths are exactly the distances, as in the library."""
    rows, cols = graph
    n = len(points)
    positions = wide(points.detach())
    x, y, z = (positions[rows] - positions[cols]).unbind(1)
    length = (x * x + y * y + z * z).sqrt()
    distance = positions.new_full((n,), float("inf")).index_fill(0, samples, 0)
    while True:
        nearer = distance.scatter_reduce(0, rows, distance.index_select(0, cols) + length, "amin")
        if torch.equal(nearer, distance):
            break
        distance = nearer
    is_tight = (distance[cols] + length == distance[rows]) & distance[rows].isfinite()
    rows, cols = rows[is_tight], cols[is_tight]
    order = torch.arange(len(samples), device=points.device)
    region = torch.full((n,), _FAR, device=points.device).index_copy(0, samples, order)
    while True:
        first = region.scatter_reduce(0, rows, region.index_select(0, cols), "amin")
        if torch.equal(first, region):
            return torch.where(region == _FAR, -1, region)
        region = first


def quotient(vertices: Any, faces: Any, graph: Any, regions: Any, n_samples: int) -> Quotient:
    """Finds edges, triangles and normals between the regions (n, -1 for none) of a mesh with the edges `graph`."""
    ends = regions[graph]
    edges = entries_of((ends[0] * n_samples + ends[1])[(ends[0] != ends[1]) & (ends.amin(0) >= 0)], n_samples)
    corners = regions[faces]
    is_reached = corners.amin(1) >= 0
    corners, faces = corners[is_reached], faces[is_reached]
    a, b, c = (wide(vertices.detach())[faces[:, corner]] for corner in range(3))
    normals = a.new_zeros((n_samples, 3))
    third = torch.linalg.cross(b - a, c - a) / 3
    for corner in range(3):
        normals = normals.index_add(0, corners[:, corner], third)
    i, j, k = corners.unbind(1)
    spanned, order = corners[(i != j) & (j != k) & (k != i)].sort(1)
    # Rotations of (0, 1, 2) keep the winding.
    sign = torch.where((order[:, 1] - order[:, 0]) % 3 == 1, 1, -1)
    keys, which = torch.unique((spanned[:, 0] * n_samples + spanned[:, 1]) * n_samples + spanned[:, 2], return_inverse=True)
    windings = torch.zeros_like(keys).index_add(0, which, sign)
    n = max(n_samples, 1)
    ij = torch.div(keys, n, rounding_mode="floor")
    triangles = torch.stack([torch.div(ij, n, rounding_mode="floor"), ij % n, keys % n], 1)
    return Quotient(edges, triangles, windings, normals)


def orient_faces(faces: Any, positions: Any, between: Quotient) -> Any:
    """Winds faces (samples, ascending) like the mesh faces between the three regions, or else by the normals of these regions."""
    n = len(positions)
    keys = (faces[:, 0] * n + faces[:, 1]) * n + faces[:, 2]
    triangles = between.triangles
    places, is_spanned = find_sorted((triangles[:, 0] * n + triangles[:, 1]) * n + triangles[:, 2], keys)
    winding = torch.zeros_like(keys)
    if len(triangles) > 0:
        winding = torch.where(is_spanned, between.windings[places], 0)
    a, b, c = (wide(positions.detach())[faces[:, corner]] for corner in range(3))
    along = (torch.linalg.cross(b - a, c - a) * between.normals[faces].sum(1)).sum(1)
    is_against = torch.where(winding == 0, along < 0, winding < 0)
    return torch.where(is_against[:, None], faces[:, [0, 2, 1]], faces)


def choose_faces(entries: Any, probabilities: Any, n_entries: int) -> Any:
    """Chooses candidates of probability above 0.5 that are among the two likeliest on all three of their edges, Sec. 4; ascending.

    `entries` are the edges of the candidates, n_candidates x 3, below `n_entries`."""
    likely = (probabilities.detach() > 0.5).nonzero()[:, 0]
    order = likely[probabilities.detach()[likely].argsort(descending=True, stable=True)]
    rank = torch.arange(len(order), 0, -1, device=entries.device)
    edges = entries[order]
    edge, ranks = edges.reshape(-1), rank[:, None].expand_as(edges).reshape(-1)
    best = most_by(ranks, edge, n_entries, 0)
    second = most_by(torch.where(ranks == best[edge], 0, ranks), edge, n_entries, 0)
    return order[(rank[:, None] >= second[edges]).all(1)].sort().values


def choose_manifold(faces: Any, probabilities: Any, n: int) -> Any:
    """Chooses wound faces (corners below n), the likeliest first, as long as no half-edge has two; ascending.

    First those of probability above 0.5, then others of which two edges have one face. By rounds: those are chosen that are the likeliest
    left at all three of their half-edges."""
    order = probabilities.detach().argsort(descending=True, stable=True)
    corners, ends = faces[order], faces[order].roll(-1, 1)
    keys, sides = torch.unique(torch.cat([corners * n + ends, ends * n + corners]), return_inverse=True)
    sides, twins = sides[: len(order)], sides[len(order) :]
    rank = torch.arange(len(order), 0, -1, device=faces.device)
    is_taken, is_chosen = torch.zeros_like(keys, dtype=torch.bool), torch.zeros_like(rank, dtype=torch.bool)
    is_likely, is_filling = probabilities.detach()[order] > 0.5, False
    while True:
        is_left = ~is_chosen & ~is_taken[sides].any(1)
        is_left &= is_taken[twins].sum(1) > 1 if is_filling else is_likely
        if not bool(is_left.any()):
            if is_filling:
                return order[is_chosen].sort().values
            is_filling = True
            continue
        best = most_by(torch.where(is_left, rank, 0)[:, None].expand_as(sides).reshape(-1), sides.reshape(-1), len(keys), 0)
        now = is_left & (best[sides] == rank[:, None]).all(1)
        is_chosen |= now
        is_taken[sides[now]] = True


def pooling_matrices(regions: Any, n_samples: int, dtype: Any) -> tuple[Any, Any]:
    """Returns the mean over each region, n_samples x n, and the copy of its value to its vertices, n x n_samples; sparse."""
    kept = (regions >= 0).nonzero()[:, 0]
    rows = regions[kept]
    counts = torch.bincount(rows, minlength=n_samples).to(dtype)
    shape = (n_samples, len(regions))
    with torch.no_grad():
        pool = torch.sparse_coo_tensor(torch.stack([rows, kept]), 1 / counts[rows], shape, check_invariants=False)
        spread = torch.sparse_coo_tensor(torch.stack([kept, rows]), torch.ones_like(rows, dtype=dtype), shape[::-1], check_invariants=False)
    return pool.coalesce(), spread.coalesce()

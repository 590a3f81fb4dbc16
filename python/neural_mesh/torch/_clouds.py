"""Surfaces of clouds of points: local Delaunay triangulations in tangent planes (Gopi, Krishnan and Silva 2000), wound outward.

No gradient passes through these functions. Constants are those of the library's `mesh-points`, which says why.
"""

from __future__ import annotations

from typing import Any

import torch

from .._native import NeuralMeshError
from ._nearest import nearest_neighbours
from ._segments import sum_by, wide

# Neighbours of a point that are triangulated, and those through which its tangent plane runs.
_AROUND, _PLANE = 15, 11
# Least length of a neighbour's projection over its distance; steeper neighbours are of another sheet.
_STEEP = 0.5
# Largest displacement of a point against ties, over the distance to its nearest neighbour, and its direction (Roberts 2018).
_JITTER, _STEPS = 0.01, (0.819_172_513_396, 0.671_043_606_704, 0.549_700_477_901)
# Points whose circles are tested at once.
_PART = 4096


def cloud_faces(points: Any, batch: Any = None, normals: Any = None) -> Any:
    """Returns triangles between neighbouring points that two of their corners have in their stars, n_faces x 3.

    - `points`: n x 3
    - `batch`: mesh of each point, ascending; one by default
    - `normals`: n x 3, towards which faces look; without, they look outward
    """
    triangles, votes, nearest = star_triangles(points, batch)
    faces, positions = triangles[votes > 1], wide(points.detach())
    a, b, c = (positions[faces[:, corner]] for corner in range(3))
    across = torch.linalg.cross(b - a, c - a)
    if normals is None:
        sign, component = _turn_alike(*_face_pairs(faces, across, nearest), len(faces))
        # The volume that a component encloses is negative if its faces look inward.
        center = sum_by((a + b + c) / 3, component, len(faces)) / torch.bincount(component, minlength=len(faces)).clamp(min=1)[:, None]
        volume = sum_by(sign * (across * (a - center[component])).sum(1), component, len(faces))
        is_against = torch.where(volume[component] < 0, sign > 0, sign < 0)
    else:
        guides = wide(torch.as_tensor(normals, device=points.device).detach())
        if guides.shape != points.shape:
            raise NeuralMeshError(f"normals: a tensor of shape {tuple(guides.shape)}: give {len(points)} x 3")
        is_against = (across * guides[faces].sum(1)).sum(1) < 0
    return torch.where(is_against[:, None], faces[:, [0, 2, 1]], faces)


def star_triangles(points: Any, batch: Any = None) -> tuple[Any, Any, Any]:
    """Finds the triangles of each point in the Delaunay triangulation of its neighbours in its tangent plane.

    Returns ascending corners (n_triangles x 3, sorted), the number of corners that have each triangle, 1 to 3, and the neighbours of each
    point (n x k, -1 for none). `points` is n x 3."""
    n = len(points)
    if n >= 1 << 21:
        raise NeuralMeshError(f"vertices: a cloud of {n} points: at most {(1 << 21) - 1} fit: give fewer, or smaller batches")
    nearest = nearest_neighbours(points, _AROUND, batch)
    positions = wide(points.detach())
    normals = _plane_normals(positions, nearest)
    positions = _jitter(positions, nearest, batch)
    pairs = torch.combinations(torch.arange(_AROUND, device=points.device))
    keys = []
    for part in torch.arange(n, device=points.device).split(_PART):
        around = nearest[part]
        flat, is_near = _unfold(positions[around] - positions[part, None], normals[part])
        which, pair = (_has_empty_circle(flat, is_near & (around >= 0), pairs)).nonzero(as_tuple=True)
        corners = torch.cat([part[which, None], around[which].gather(1, pairs[pair])], 1).sort(1).values
        keys.append((corners[:, 0] * n + corners[:, 1]) * n + corners[:, 2])
    found, votes = torch.unique(torch.cat(keys), return_counts=True)
    first = torch.div(found, n, rounding_mode="floor")
    return torch.stack([torch.div(first, n, rounding_mode="floor"), first % n, found % n], 1), votes, nearest


def _plane_normals(positions: Any, nearest: Any) -> Any:
    """Returns the normal of the plane through each point's neighbours, n x 3, of either sign; zero on a line."""
    some = nearest[:, :_PLANE]
    counts = (some >= 0).sum(1, keepdim=True)[..., None] + 1
    offsets = torch.where((some >= 0)[..., None], positions[some] - positions[:, None], 0)
    centered = torch.cat([torch.zeros_like(positions)[:, None], offsets], 1) - offsets.sum(1, keepdim=True) / counts
    # Rows of absent neighbours would count as points.
    weights = torch.cat([torch.ones_like(some[:, :1]), (some >= 0).long()], 1)[..., None]
    values, vectors = torch.linalg.eigh((centered * weights).transpose(1, 2) @ centered)
    return torch.where((values[:, 1] > 1e-12 * values[:, 2])[:, None], vectors[:, :, 0], 0)


def _jitter(positions: Any, nearest: Any, batch: Any) -> Any:
    """Moves points a little, so that the corners of a square choose the same diagonal."""
    order = torch.arange(len(positions), device=positions.device)
    if batch is not None:
        order = order - torch.searchsorted(batch, batch)
    reach = (positions[nearest[:, :1]] - positions[:, None]).norm(dim=2)
    steps = positions.new_tensor(_STEPS)
    return positions + torch.where(nearest[:, :1] >= 0, _JITTER * reach, 0) * ((order[:, None] * steps).frac() - 0.5)


def _unfold(offsets: Any, normals: Any) -> tuple[Any, Any]:
    """Turns offsets into their tangent planes, keeping their lengths: n x k x 2, and whether a neighbour is not too steep: n x k."""
    # The axis least along the normal gives a tangent of the largest length.
    axis = torch.nn.functional.one_hot(normals.abs().argmin(1), 3).to(normals.dtype)
    x = torch.nn.functional.normalize(torch.linalg.cross(normals, axis), dim=1)
    tangents = torch.stack([x, torch.linalg.cross(normals, x)], 2)
    flat, length = offsets @ tangents, offsets.norm(dim=2)
    short = flat.norm(dim=2)
    return flat * (length / short.clamp(min=1e-300))[..., None], short > _STEEP * length


def _has_empty_circle(flat: Any, is_there: Any, pairs: Any) -> Any:
    """Returns for each pair of neighbours whether no other is within their circle with the point itself: n x n_pairs."""
    (ax, ay), (bx, by) = (flat[:, pairs[:, end]].unbind(2) for end in (0, 1))
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    twice = ax * by - ay * bx
    # The circle's center times `twice`, for which nothing is divided; both sides change their sign with it.
    center = torch.stack([by * a2 - ay * b2, ax * b2 - bx * a2], 2) * twice.sign()[..., None]
    inside = center @ flat.transpose(1, 2) > twice.abs()[..., None] * flat.square().sum(2)[:, None]
    own = torch.nn.functional.one_hot(pairs, flat.shape[1]).sum(1).bool()
    is_empty = ~(inside & ~own & is_there[:, None]).any(2)
    is_corner = is_there[:, pairs[:, 0]] & is_there[:, pairs[:, 1]]
    return is_empty & is_corner & (twice.square() > 1e-18 * a2 * b2)


def _face_pairs(faces: Any, across: Any, nearest: Any) -> tuple[Any, Any]:
    """Returns pairs of faces (ascending corners), 2 x n_pairs, and 1 or -1 where both are wound alike or not, the surest first.

    First come faces with a common edge, the flattest first; then faces at neighbouring points, the most parallel first, which join
    components."""
    n, own = len(nearest), torch.arange(len(faces), device=faces.device)
    unit = torch.nn.functional.normalize(across, dim=1)
    sides = torch.cat([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [0, 2]]])
    edge, order = (sides[:, 0] * n + sides[:, 1]).sort(stable=True)
    _, counts = torch.unique_consecutive(edge, return_counts=True)
    first = (counts.cumsum(0) - counts)[counts == 2]
    at = torch.stack([order[first], order[first + 1]])
    # Ascending corners go along the first two sides and against the third.
    m = max(len(faces), 1)
    turns = torch.where((at[0] >= 2 * m) == (at[1] >= 2 * m), -1.0, 1.0).to(unit.dtype)
    ends = at % m
    by_flatness = (turns * (unit[ends[0]] * unit[ends[1]]).sum(1)).argsort(descending=True, stable=True)
    # Some face at each point: the one with the largest number, so that it is the same on every device.
    numbers = torch.arange(3 * len(faces), device=faces.device)
    some = torch.full((n,), -1, device=faces.device).scatter_reduce(0, faces.t().reshape(-1), numbers, "amax")
    some = torch.where(some >= 0, some % m, -1)
    near = torch.stack([some[:, None].expand_as(nearest)[nearest >= 0], some[nearest[nearest >= 0]]])
    near = near[:, (near >= 0).all(0)]
    dots = (unit[near[0]] * unit[near[1]]).sum(1)
    by_angle = dots.abs().argsort(descending=True, stable=True)
    near_turns = torch.where(dots < 0, -1.0, 1.0).to(unit.dtype)
    return torch.cat([ends[:, by_flatness], near[:, by_angle]], 1), torch.cat([turns[by_flatness], near_turns[by_angle]])


def _turn_alike(ends: Any, turns: Any, n: int) -> tuple[Any, Any]:
    """Returns 1 or -1 for each of n nodes, so that pairs agree along the tree of the first ones (Hoppe et al. 1992), and components.

    - `ends`: 2 x n_pairs, the surest pair first; `turns`: n_pairs, 1 or -1 where both ends are alike or not

    The tree grows by rounds: each component takes its best pair with another (Boruvka 1926)."""
    own = torch.arange(n, device=ends.device)
    # Both directions of each pair have its rank.
    rows, cols = torch.cat([ends[0], ends[1]]), torch.cat([ends[1], ends[0]])
    rank, turns = torch.arange(ends.shape[1], device=own.device).repeat(2), turns.repeat(2)
    component, sign = own, torch.ones(n, dtype=turns.dtype, device=own.device)
    while True:
        is_outer = component[rows] != component[cols]
        rows, cols, rank, turns = rows[is_outer], cols[is_outer], rank[is_outer], turns[is_outer]
        if len(rows) == 0:
            return sign, component
        best = torch.full_like(own, ends.shape[1]).scatter_reduce(0, component[rows], rank, "amin")
        chosen = best[component[rows]] == rank
        one, other = component[rows[chosen]], component[cols[chosen]]
        parent, turn = own.index_copy(0, one, other), torch.ones_like(sign)
        turn[one] = sign[rows[chosen]] * sign[cols[chosen]] * turns[chosen]
        # Two components that chose the same edge would be each other's parents.
        is_root = (parent[parent] == own) & (own <= parent)
        parent, turn = torch.where(is_root, own, parent), torch.where(is_root, 1.0, turn)
        while not torch.equal(parent[parent], parent):
            turn, parent = turn * turn[parent], parent[parent]
        sign, component = sign * turn[component], parent[component]

"""Closing of the holes between wound faces by cutting ears off them, all holes at once.

A half-edge of a face is open if no face has its twin. Holes lie to the right of their open half-edges. No gradient passes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from ._segments import find_sorted, least_by, sum_by, wide

# Twice the area of the largest hole that is closed, over its circumference, in mean edges, and the longest new edge; of the library.
_LARGEST_HOLE, _LONGEST_EDGE = 3.0, 8.0
# Components of fewer faces are removed if they are open.
_FEWEST_FACES = 8
# Most rounds of closing and removing faces.
_ROUNDS = 8


class _Rims(NamedTuple):
    """Open half-edges, by their starts, then ends."""

    starts: Any
    ends: Any
    next: Any
    """The next one along the hole of each; -1 where fans of faces overlap."""


def close_surface(faces: Any, points: Any, normals: Any) -> tuple[Any, Any]:
    """Closes small holes between wound faces by new ones, and removes faces where that fails.

    Returns wound faces, n_result x 3, and which of the given ones each is, -1 for new ones.

    - `faces`: n_faces x 3, no half-edge twice
    - `points`: n x 3, in mean edges; `normals`: n x 3, of any length, to the side from which faces are wound counterclockwise
    """
    points, normals = wide(points.detach()), wide(normals)
    own = torch.arange(len(faces), device=faces.device)
    for number in range(_ROUNDS):
        is_kept = ~_is_small(faces, len(points))
        if number > 0:
            # First the faces along such a hole go, then all that touch it.
            is_kept &= ~_touches_hole(faces, points, normals, number % 2 == 0)
            if bool(is_kept.all()):
                break
        faces, own = faces[is_kept], own[is_kept]
        new = _cut_ears(faces, points, normals)
        faces, own = torch.cat([faces, new]), torch.cat([own, torch.full_like(new[:, 0], -1)])
    return faces, own


def _cut_ears(faces: Any, points: Any, normals: Any) -> Any:
    """Returns faces that close small holes, n_new x 3.

    Ears join the ends of successive open half-edges. In each round, those are cut whose new edge is the shortest around. Ears that look
    away from the normals wait until there are no others."""
    n = len(points)
    starts, ends = faces.reshape(-1), faces.roll(-1, 1).reshape(-1)
    taken = (starts * n + ends).sort().values
    cut = [faces[:0]]
    while True:
        rims = _follow(starts, ends, points, normals)
        at = ((rims.next >= 0) & _is_small_hole(rims, points)).nonzero()[:, 0]
        a, b, c = rims.starts[at], rims.ends[at], rims.ends[rims.next[at]]
        length = (points[a] - points[c]).norm(dim=1)
        is_free = ~find_sorted(taken, a * n + c)[1] & (length < _LONGEST_EDGE)
        across = torch.linalg.cross(points[b] - points[c], points[a] - points[c])
        is_along = is_free & ((across * (normals[a] + normals[b] + normals[c])).sum(1) > 0)
        some = is_along if bool(is_along.any()) else is_free
        ears = torch.stack([c, b, a], 1)[some]
        if len(ears) == 0:
            return torch.cat(cut)
        ears = ears[_is_least(ears, length[some], n)]
        cut.append(ears)
        sides = ears.reshape(-1), ears.roll(-1, 1).reshape(-1)
        taken = torch.cat([taken, sides[0] * n + sides[1]]).sort().values
        starts, ends = torch.cat([rims.starts, sides[0]]), torch.cat([rims.ends, sides[1]])


def _is_least(faces: Any, costs: Any, n: int) -> Any:
    """Marks the faces that cost least among those with which they share a half-edge; of equal ones, the first."""
    keys, sides = torch.unique(faces * n + faces.roll(-1, 1), return_inverse=True)
    order = costs.argsort(stable=True)
    rank = torch.empty_like(order).index_copy(0, order, torch.arange(len(order), device=order.device))
    best = least_by(rank[:, None].expand_as(sides).reshape(-1), sides.reshape(-1), len(keys), len(order))
    return (best[sides] == rank[:, None]).all(1)


def _follow(starts: Any, ends: Any, points: Any, normals: Any) -> _Rims:
    """Joins open half-edges to rims: at each vertex, an incoming one goes on in the next outgoing one counterclockwise.

    Half-edges with a twin among the given ones are left out."""
    n = len(points)
    keys, order = (starts * n + ends).sort()
    order = order[~find_sorted(keys, ends[order] * n + starts[order])[1]]
    starts, ends = starts[order], ends[order]
    m = len(starts)
    vertex, other = torch.cat([ends, starts]), torch.cat([starts, ends])
    axis = torch.nn.functional.one_hot(normals[vertex].abs().argmin(1), 3).to(normals.dtype)
    normal = torch.nn.functional.normalize(normals[vertex], dim=1)
    x, d = torch.linalg.cross(normal, axis), points[other] - points[vertex]
    angle = torch.atan2((d * torch.linalg.cross(normal, x)).sum(1), (d * x).sum(1))
    order = angle.argsort(stable=True)
    order = order[vertex[order].argsort(stable=True)]
    group = vertex[order]
    is_last = torch.cat([group[1:] != group[:-1], torch.ones_like(group[:1], dtype=torch.bool)])
    after = order[torch.where(is_last, torch.searchsorted(group, group), torch.arange(1, 2 * m + 1, device=order.device))]
    is_pair = (order < m) & (after >= m)
    follower = torch.full((m,), -1, device=order.device).index_copy(0, order[is_pair], after[is_pair] - m)
    return _Rims(starts, ends, follower)


def _is_small_hole(rims: _Rims, points: Any) -> Any:
    """Marks the half-edges whose hole is small, m."""
    m = len(rims.starts)
    first = torch.arange(m, device=rims.starts.device)
    step = torch.where(rims.next >= 0, rims.next, first)
    # Each round, the first half-edge of twice as many successive ones is known.
    while not torch.equal(torch.minimum(first, first[step]), first):
        first, step = torch.minimum(first, first[step]), step[step]
    a, b = (points[end] - points[rims.starts[first]] for end in (rims.starts, rims.ends))
    twice_area = sum_by(torch.linalg.cross(a, b), first, m + 1).norm(dim=1)
    around = sum_by((a - b).norm(dim=1), first, m + 1)
    return (twice_area < _LARGEST_HOLE * around)[first]


def _twins(faces: Any, n: int) -> Any:
    """Returns the half-edge (3 * face + corner at its start) opposite to each, 3 n_faces; -1 for open ones."""
    keys, order = (faces * n + faces.roll(-1, 1)).reshape(-1).sort()
    places, is_there = find_sorted(keys, (faces.roll(-1, 1) * n + faces).reshape(-1))
    return torch.where(is_there, order[places], -1)


def _is_small(faces: Any, n: int) -> Any:
    """Marks the faces of open components of fewer than `_FEWEST_FACES`."""
    twins = _twins(faces, n).reshape(-1, 3)
    own = torch.arange(len(faces), device=faces.device)
    adjacent = torch.where(twins >= 0, torch.div(twins, 3, rounding_mode="floor"), own[:, None])
    label = own
    # After as many steps, a small component has one label; a larger one may have parts of one, which have other neighbours.
    for _ in range(_FEWEST_FACES):
        label = torch.minimum(label, label[adjacent].amin(1))
    is_whole = (label[adjacent] == label[:, None]).all(1)
    counts, others, n_open = (torch.bincount(label[rows], minlength=len(faces)) for rows in (own, own[~is_whole], own[(twins < 0).any(1)]))
    return ((counts < _FEWEST_FACES) & (others == 0) & (n_open > 0))[label]


def _touches_hole(faces: Any, points: Any, normals: Any, with_corners: bool) -> Any:
    """Marks the faces with an edge on a small hole, or where fans of faces overlap; with a corner, if `with_corners`."""
    rims = _follow(faces.reshape(-1), faces.roll(-1, 1).reshape(-1), points, normals)
    is_at_hole = torch.zeros(len(points), dtype=torch.bool, device=points.device)
    is_at_hole[rims.starts[_is_small_hole(rims, points) | (rims.next < 0)]] = True
    touches = is_at_hole[faces].any(1)
    return touches if with_corners else touches & (_twins(faces, len(points)) < 0).reshape(-1, 3).any(1)

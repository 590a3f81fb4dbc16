"""Nearest points, exact, by grids of several cell sizes over one sorted order (Morton 1966)."""

from __future__ import annotations

from typing import Any

import torch

# Bits of a coordinate: cells of 2^-15 of the mesh's size are the smallest. With 3 * 15 bits of a cell, 18 are left for meshes.
_BITS = 15
# Cells of a block: the query's and all around it.
_AROUND = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
# Points of a padded row, in all rows handled at once.
_ROWS = 1 << 24


def nearest_to(points: Any, queries: Any, k: int, point_batch: Any = None, query_batch: Any = None) -> Any:
    """Finds the `k` points nearest to each query of the same mesh, nearest first: n_queries x k, -1 where there are fewer.

    Distances are compared in single precision; ties go to the lower index.

    - `points`: n x 3
    - `queries`: n_queries x 3
    - `point_batch`, `query_batch`: mesh of each, ascending; one mesh by default
    """
    points, queries = points.detach().float(), queries.detach().float()
    found = torch.full((len(queries), k), -1, dtype=torch.int64, device=points.device)
    if len(points) == 0 or len(queries) == 0 or k == 0:
        return found
    if point_batch is None:
        point_batch, query_batch = (torch.zeros(len(x), dtype=torch.int64, device=x.device) for x in (points, queries))
    grid = _Grid(points, queries, point_batch, query_batch)
    waiting = torch.arange(len(queries), device=points.device)
    level_of = grid.first_levels(max(k // 5, 2))
    for level in range(_BITS + 1):
        now = waiting[level_of[waiting] <= level]
        if len(now) == 0:
            continue
        is_done = grid.search(now, k, level, found)
        is_waiting = torch.zeros(len(queries), dtype=torch.bool, device=points.device).index_fill(0, waiting, True)
        is_waiting[now[is_done]] = False
        waiting = is_waiting.nonzero()[:, 0]
    return found


def nearest_neighbours(points: Any, k: int, batch: Any = None) -> Any:
    """Finds the `k` nearest other points of every point of the same mesh: n x k, -1 where there are fewer."""
    rows = nearest_to(points, points, k + 1, batch, batch)
    # A point at the same position may come before the point itself.
    own = torch.arange(len(points), device=points.device)[:, None]
    is_other = rows != own
    is_other[:, -1] &= ~is_other[:, :-1].all(1)
    order = (~is_other).to(torch.int8).argsort(dim=1, stable=True)
    return rows.gather(1, order)[:, :k]


class _Grid:
    """Points and queries in cells; a coarser cell is a prefix of the key of a finer one."""

    def __init__(self, points: Any, queries: Any, point_batch: Any, query_batch: Any) -> None:
        n_meshes = int(torch.stack([point_batch[-1], query_batch[-1]]).max()) + 1
        both, meshes = torch.cat([points, queries]), torch.cat([point_batch, query_batch])
        meshes3 = meshes[:, None].expand(-1, 3)
        low = both.new_full((n_meshes, 3), float("inf")).scatter_reduce(0, meshes3, both, "amin")
        high = both.new_full((n_meshes, 3), float("-inf")).scatter_reduce(0, meshes3, both, "amax")
        extent = (high - low).amax(1).clamp(min=1e-30)
        self.points, self.queries = points, queries
        self.unit = (extent / (1 << _BITS))[query_batch]
        self.place = (queries - low[query_batch]) / self.unit[:, None]
        self.cell = self.place.long().clamp(0, (1 << _BITS) - 1)
        self.mesh = query_batch
        cells = ((points - low[point_batch]) / (extent / (1 << _BITS))[point_batch, None]).long().clamp(0, (1 << _BITS) - 1)
        self.keys, self.order = (point_batch << (3 * _BITS) | _interleave(cells)).sort()

    def _ranges(self, cell: Any, mesh: Any, level: int) -> tuple[Any, Any]:
        """Returns the start and number of the points in cells of a level, in the sorted order."""
        key = (mesh << (3 * _BITS) | _interleave(cell) << (3 * level))
        start = torch.searchsorted(self.keys, key)
        return start, torch.searchsorted(self.keys, key + (1 << (3 * level))) - start

    def first_levels(self, least: int) -> Any:
        """Returns the finest level at which a query's own cell has at least so many points."""
        key = self.mesh << (3 * _BITS) | _interleave(self.cell)
        levels = torch.zeros_like(key)
        for level in range(_BITS):
            start = key >> (3 * level) << (3 * level)
            ends = torch.searchsorted(self.keys, torch.stack([start, start + (1 << (3 * level))]))
            levels += ends[1] - ends[0] < least
        return levels

    def search(self, now: Any, k: int, level: int, found: Any) -> Any:
        """Writes the nearest points of some queries among the blocks around them; returns which are certain."""
        side, n_cells = 1 << level, 1 << (_BITS - level)
        cells = (self.cell[now] >> level)[:, None] + torch.tensor(_AROUND, device=now.device)
        is_inside = ((cells >= 0) & (cells < n_cells)).all(2)
        starts, counts = self._ranges(cells.clamp(0, n_cells - 1), self.mesh[now, None].expand(-1, len(_AROUND)), level)
        counts = torch.where(is_inside, counts, 0)
        totals = counts.sum(1)
        # Nothing outside the block is nearer than its border; the margin covers rounding of places.
        within = self.place[now] - (self.cell[now] >> level) * side
        border = (torch.minimum(within, side - within).amin(1) + side - 0.01).clamp(min=0) * self.unit[now]
        is_whole = level == _BITS
        is_done = torch.zeros(len(now), dtype=torch.bool, device=now.device)
        width = 64
        # Of few points in a block, the farthest is most often beyond its border.
        left = ((totals >= 2 * k) | is_whole).nonzero()[:, 0]
        while len(left) > 0:
            fits = totals[left] <= width
            some = left[fits]
            for rows in some.split(max(_ROWS // width, 1)) if len(some) > 0 else ():
                keys = self._distances(now[rows], starts[rows], counts[rows], width)
                # A mesh of fewer points than the row is wide has all of them in it.
                best = keys.topk(min(k, width), 1, largest=False).values
                reached = (best[:, -1] >> 32).to(torch.int32).view(torch.float32)
                is_certain = torch.full_like(reached, is_whole, dtype=torch.bool) | (reached <= border[rows].square())
                none = best == _NONE
                indices = torch.where(none, -1, best & 0xFFFFFFFF)
                certain = rows[is_certain]
                found[now[certain], : best.shape[1]] = indices[is_certain]
                is_done[certain] = True
            left = left[~fits]
            width *= 2
        return is_done

    def _distances(self, queries: Any, starts: Any, counts: Any, width: int) -> Any:
        """Returns squared distances above indices, packed into int64, of the points in the ranges: n_queries x width."""
        ends = counts.cumsum(1)
        place = torch.arange(width, device=starts.device).expand(len(queries), -1).contiguous()
        which = torch.searchsorted(ends, place, right=True).clamp(max=len(_AROUND) - 1)
        at = starts.gather(1, which) + place - (ends - counts).gather(1, which)
        index = self.order[at.clamp(0, len(self.order) - 1)]
        d = self.points[index] - self.queries[queries, None]
        squared = d[..., 0] * d[..., 0] + d[..., 1] * d[..., 1] + d[..., 2] * d[..., 2]
        packed = squared.view(torch.int32).long() << 32 | index
        return torch.where(place < ends[:, -1:], packed, _NONE)


_NONE = 0x7F800000 << 32


def _interleave(cells: Any) -> Any:
    """Interleaves the bits of three coordinates, `[..., 3]` int64."""
    x = cells
    for shift, mask in ((32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249)):
        x = (x | x << shift) & mask
    return x[..., 0] << 2 | x[..., 1] << 1 | x[..., 2]

"""Sums, extremes and softmax over groups of rows, ranges, and random numbers that are the same on every device.

Graphs are `[2, n_entries]` tensors of int64: rows above columns, sorted by row, then column, each entry once.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import torch

# Entries times channels that a stage without gradients handles at once: what fits a core's cache, and what keeps a GPU busy.
_PART = {"cpu": 1 << 18}
_PART_ELSEWHERE = 1 << 27


def parts(n: int, width: int, device: Any) -> Iterator[slice]:
    """Cuts `n` rows of `width` numbers into slices, so that intermediate results stay small; one slice while compiling."""
    step = n if torch.compiler.is_compiling() else max(_PART.get(device.type, _PART_ELSEWHERE) // width, 1)
    if torch.compiler.is_compiling() or n <= step:
        yield slice(None)
        return
    for start in range(0, n, step):
        yield slice(start, start + step)


def sum_by(values: Any, index: Any, n: int) -> Any:
    """Sums rows of `values` by `index`: n rows."""
    # One group of all rows: on a GPU, additions to one place would wait for each other.
    if n == 1 and not torch.compiler.is_compiling():
        return values.sum(0, keepdim=True)
    return values.new_zeros((n, *values.shape[1:])).index_add(0, index, values)


def least_by(values: Any, index: Any, n: int, start: float = float("inf")) -> Any:
    """Returns the least of the numbers of each group, at most `start`: n."""
    return values.new_full((n,), start).scatter_reduce(0, index, values, "amin")


def most_by(values: Any, index: Any, n: int, start: float = float("-inf")) -> Any:
    """Returns the largest of the numbers of each group, at least `start`: n."""
    return values.new_full((n,), start).scatter_reduce(0, index, values, "amax")


def neighbour_least(values: Any, graph: Any) -> Any:
    """Returns the least of the neighbours' values in each channel, n x width; a node's own where it has no neighbour."""
    rows, cols = graph
    width = values.shape[1]
    start = torch.full_like(values, float("inf"))
    if torch.is_grad_enabled() and values.requires_grad:
        least = start.scatter_reduce(0, rows[:, None].expand(-1, width), values.index_select(0, cols), "amin")
    else:
        least = start
        for part in parts(rows.shape[0], width, values.device):
            least = least.scatter_reduce_(0, rows[part, None].expand(-1, width), values.index_select(0, cols[part]), "amin")
    return torch.where(least == float("inf"), values, least)


def softmax_by(values: Any, index: Any, n: int) -> Any:
    """Computes the softmax of the numbers within each group."""
    top = most_by(values.detach(), index, n)
    weights = (values - top.index_select(0, index)).exp()
    return weights / values.new_zeros(n).index_add(0, index, weights).index_select(0, index)


def row_starts(rows: Any, n: int) -> Any:
    """Returns the first entry of each row, and the number of entries last: n + 1."""
    return torch.searchsorted(rows.contiguous(), torch.arange(n + 1, device=rows.device))


def expand_ranges(starts: Any, counts: Any) -> tuple[Any, Any]:
    """Lists `starts[i] .. starts[i] + counts[i]` for all i; returns i and the number of each."""
    owner = torch.repeat_interleave(torch.arange(len(counts), device=counts.device), counts)
    first = counts.cumsum(0) - counts
    return owner, torch.arange(len(owner), device=counts.device) - (first - starts)[owner]


def find_sorted(keys: Any, wanted: Any) -> tuple[Any, Any]:
    """Finds `wanted` among ascending `keys`; returns their places and a mask of those that are there."""
    if len(keys) == 0:
        return torch.zeros_like(wanted), torch.zeros_like(wanted, dtype=torch.bool)
    places = torch.searchsorted(keys, wanted).clamp_(max=len(keys) - 1)
    return places, keys[places] == wanted


def entries_of(keys: Any, n: int) -> Any:
    """Returns the graph whose entries have the keys `row * n + column`, in any order and number."""
    keys = torch.unique(keys)
    return torch.stack([torch.div(keys, max(n, 1), rounding_mode="floor"), keys % max(n, 1)])


def wide(values: Any) -> Any:
    """Converts to double precision, or to single where the device has no double."""
    return values.to(torch.float32 if values.device.type == "mps" else torch.float64)


def random_uniform(place: Any, seed: Any) -> Any:
    """Returns numbers within (0, 1), double, that depend only on `place` and `seed` (int64): splitmix64 (Steele et al. 2014)."""
    x = (place + 1) * -7046029254386353131 + (seed + 1) * -7723592293110705685
    for shift, factor in ((30, -4658895280553007687), (27, -7723592293110705685)):
        # Shifts of negative numbers fill with ones, which the mask removes.
        x = (x ^ ((x >> shift) & ((1 << (64 - shift)) - 1))) * factor
    x = x ^ ((x >> 31) & ((1 << 33) - 1))
    return (wide((x >> 11) & ((1 << 53) - 1)) + 0.5) / (1 << 53)

"""Draws of samples by scores (Sec. 3.1), and the gradient through a draw."""

from __future__ import annotations

from typing import Any

import torch

from ._segments import least_by, most_by, random_uniform, row_starts, sum_by, wide

# Constants of the library's `scattered_samples`, which says why.
_MOST_SCORE = 6.0
_FIRST_REACH = 1.2
# Ratio of the reaches of successive rounds; the library's is 0.92, with all darts of a reach thrown.
_SHRINKING = 0.92
# Rounds after which the remaining samples are taken whatever their distance; only vertices at one position are that near.
_MOST_ROUNDS = 128


def sample_counts(batch: Any, n_meshes: int, ratio: float | None, n_samples: Any = None) -> Any:
    """Returns the number of samples of each mesh: a share of its vertices, or the given number, at most all: n_meshes."""
    sizes = torch.bincount(batch, minlength=n_meshes)
    if n_samples is None:
        # Rounded down, so that a result is never larger than the requested share.
        return (wide(sizes) * ratio).long().clamp(min=1).minimum(sizes)
    return torch.as_tensor(n_samples, device=batch.device).expand(n_meshes).minimum(sizes)


def arrival_keys(scores: Any, batch: Any, seeds: Any) -> Any:
    """Returns scores plus Gumbel noise of the vertex within its mesh and the mesh's seed, double: the order of draws, largest first."""
    starts = row_starts(batch, len(seeds))
    uniform = random_uniform(torch.arange(len(scores), device=scores.device) - starts[batch], seeds[batch])
    return wide(scores.detach()) - (-uniform.log()).log()


def multinomial_samples(scores: Any, counts: Any, batch: Any, seeds: Any) -> Any:
    """Draws vertices one by one with probabilities proportional to `exp(score)` among the rest, as the paper prints; ascending.

    The largest sums of score and Gumbel noise win (Kool et al. 2019).

    - `scores`: n; `counts`: samples of each mesh; `batch`: mesh of each vertex; `seeds`: one for each mesh
    """
    rank = _ranks(arrival_keys(scores, batch, seeds), batch, len(counts))
    return (rank < counts[batch]).nonzero()[:, 0]


def _ranks(keys: Any, batch: Any, n_meshes: int) -> Any:
    """Returns the number of larger keys in a vertex's mesh."""
    order = keys.argsort(descending=True, stable=True)
    if n_meshes > 1:
        order = order[batch[order].argsort(stable=True)]
    rank = torch.empty_like(order)
    rank[order] = torch.arange(len(order), device=order.device) - row_starts(batch, n_meshes)[batch]
    return rank


def scattered_samples(points: Any, graph: Any, scores: Any, counts: Any, batch: Any, seeds: Any) -> Any:
    """Draws vertices with a density proportional to `exp(score)`, kept apart from each other; ascending.

    Dart throwing by rounds (McCool and Fiume 1992; Luby 1986): in a round, each vertex with no sample within the reach becomes one if
    its key is the largest of those vertices within the reach. The reach shrinks from round to round. Distances run along the edges,
    stretched by the scores. Two samples of a round can be nearer than the reach where a vertex between them had a larger key.

    - `points`: n x 3; `graph`: edges of the mesh; others as for `multinomial_samples`
    """
    n, n_meshes = len(scores), len(counts)
    starts = row_starts(batch, n_meshes)
    # Of a mesh, the vertex of the first draw has the largest priority; each has its own.
    priority = n - _ranks(arrival_keys(scores, batch, seeds), batch, n_meshes)
    scores, reach = _stretch(points, graph, scores.detach(), counts, batch)
    rows, cols = graph
    distance_to = (points.detach()[rows] - points.detach()[cols]).norm(dim=1).float()
    length = 0.5 * (scores[rows] + scores[cols]) * distance_to
    # Vertices without edges are on no surface: they are drawn if nothing else is left.
    distance = torch.full((n,), -1.0, device=points.device).index_fill(0, rows, float("inf"))
    is_sample = torch.zeros(n, dtype=torch.bool, device=points.device)
    left = counts.clone()
    for _ in range(_MOST_ROUNDS):
        limit = torch.where(left > 0, reach, 0)[batch]
        # What is nearer than half a reach to a sample is on no path between two vertices that are a reach from all of them.
        is_near = (distance >= 0.5 * limit) & (limit > 0)
        active = (is_near[rows] & is_near[cols]).nonzero()[:, 0]
        edges = (rows[active], cols[active], length[active])
        waiting = (distance >= limit) & (limit > 0) & ~is_sample
        chosen = waiting & (_best_within(torch.where(waiting, priority, 0), edges, limit) == priority)
        chosen = _first_of(chosen, priority, left, batch, starts)
        is_sample |= chosen
        left = left - sum_by(chosen.long(), batch, n_meshes)
        if not bool((left > 0).any()):
            return is_sample.nonzero()[:, 0]
        distance = _nearer(torch.where(chosen, 0, distance), edges, limit)
        reach = reach * _SHRINKING
    return (is_sample | _first_of(~is_sample, priority, left, batch, starts)).nonzero()[:, 0]


def _stretch(points: Any, graph: Any, scores: Any, counts: Any, batch: Any) -> tuple[Any, Any]:
    """Returns `sqrt(exp(score) / area)` of each vertex, n, and the first reach of each mesh; the area is its mean squared edge."""
    rows, cols = graph
    n, n_meshes = len(points), len(counts)
    sizes = torch.bincount(batch, minlength=n_meshes).clamp(min=1)
    mean = sum_by(wide(scores), batch, n_meshes) / sizes
    density = (wide(scores) - mean[batch]).clamp(-_MOST_SCORE, _MOST_SCORE).exp()
    squared = (points.detach()[rows] - points.detach()[cols]).square().sum(1).float()
    sums = sum_by(squared, rows, n)
    degrees = torch.bincount(rows, minlength=n)
    stretch = torch.where(sums > 0, density.float() * degrees / torch.where(sums > 0, sums, 1), 0).sqrt()
    # In the densest arrangement, of triangles, each sample has an area of sqrt(3) / 2 of its squared distance.
    reach = _FIRST_REACH * (2 / 3**0.5 * sum_by(density, batch, n_meshes) / counts.clamp(min=1)).sqrt()
    return stretch, reach.float()


def _best_within(priority: Any, edges: tuple[Any, Any, Any], limit: Any) -> Any:
    """Returns the largest priority from which a path shorter than the limit leads to each vertex."""
    rows, cols, length = edges
    # Priority above, and below it what is left of the limit, so that the maximum of a vertex has the shortest path.
    best = priority << 32 | limit.view(torch.int32)
    while True:
        sent = best.index_select(0, cols)
        rest = (sent & 0xFFFFFFFF).to(torch.int32).view(torch.float32) - length
        sent = torch.where(rest > 0, (sent & ~0xFFFFFFFF) | rest.view(torch.int32), 0)
        larger = best.scatter_reduce(0, rows, sent, "amax")
        if torch.equal(larger, best):
            return best >> 32
        best = larger


def _nearer(distance: Any, edges: tuple[Any, Any, Any], limit: Any) -> Any:
    """Relaxes distances along the edges, up to the limit."""
    rows, cols, length = edges
    limit_of = limit.index_select(0, rows)
    while True:
        reached = distance.index_select(0, cols) + length
        reached = torch.where(reached < limit_of, reached, float("inf"))
        nearer = distance.scatter_reduce(0, rows, reached, "amin")
        if torch.equal(nearer, distance):
            return distance
        distance = nearer


def _first_of(chosen: Any, priority: Any, left: Any, batch: Any, starts: Any) -> Any:
    """Keeps of the chosen vertices those of largest priority, as many as are left to be drawn of each mesh."""
    where = chosen.nonzero()[:, 0]
    counts = sum_by(chosen.long(), batch, len(left))
    if not bool((counts > left).any()):
        return chosen
    order = where[priority[where].argsort(descending=True)]
    order = order[batch[order].argsort(stable=True)]
    rank = torch.arange(len(order), device=order.device) - (counts.cumsum(0) - counts)[batch[order]]
    return torch.zeros_like(chosen).index_put((order,), rank < left[batch[order]])


def inclusion(scores: Any, counts: Any, batch: Any = None) -> Any:
    """Computes each vertex's probability to be among the first draws of its mesh, n; differentiable twice.

    Vertex i arrives after an exponential time of rate `exp(s_i)`: by time t with probability `pi_i = 1 - exp(-t exp(s_i))`; t solves
    `sum_i pi_i = count`.

    - `scores`: n
    - `counts`: samples of each mesh, or a number
    - `batch`: mesh of each vertex, ascending; one mesh by default
    """
    batch = torch.zeros(len(scores), dtype=torch.int64, device=scores.device) if batch is None else batch
    counts = torch.as_tensor(counts, device=scores.device).reshape(-1)
    n_meshes, rates = len(counts), wide(scores)
    sizes = torch.bincount(batch, minlength=n_meshes)
    wanted = wide(counts).minimum(wide(sizes) - 1e-9 * sizes)
    with torch.no_grad():
        fixed = rates.detach()
        low = most_by(fixed, batch, n_meshes).neg() - 2 * wide(sizes).clamp(min=2).log()
        high = 4 - least_by(fixed, batch, n_meshes) + wide(sizes).clamp(min=2).log()
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            expected, _ = _arrivals(fixed, middle, batch)
            is_late = expected > wanted
            low, high = torch.where(is_late, low, middle), torch.where(is_late, middle, high)
    time = (low + high) / 2
    # At the root, Newton's step changes nothing but the derivatives: the first by one step, the second by two.
    for _ in range(2):
        expected, slope = _arrivals(rates, time, batch)
        time = time - (expected - wanted) / slope.clamp(min=1e-300)
    is_all = (counts >= sizes)[batch]
    probabilities = -torch.expm1(-(rates + time[batch]).clamp(max=_FASTEST).exp())
    return torch.where(is_all, 1, torch.where((counts <= 0)[batch], 0, probabilities)).to(scores.dtype)


# Steps of bisection: a bracket of a thousand shrinks below the rounding of its ends.
_BISECTIONS = 48
# Above this exponent an arrival is certain in double precision.
_FASTEST = 6.5


def _arrivals(rates: Any, time: Any, batch: Any) -> tuple[Any, Any]:
    """Returns the expected arrivals of each mesh by the logarithm of a time, and their derivative to it."""
    rate = (rates + time[batch]).clamp(max=_FASTEST).exp()
    return (sum_by(x, batch, len(time)) for x in (-torch.expm1(-rate), rate * (-rate).exp()))  # type: ignore[return-value]


def log_probability(inclusion: Any, samples: Any, batch: Any, n_meshes: int) -> Any:
    """Returns the logarithm of the probability of each mesh's samples, each vertex drawn with its inclusion probability: n_meshes.

    The score function's gradient of an expected loss is that of `(loss - baseline).detach() * log_probability`."""
    drawn = torch.zeros_like(inclusion, dtype=torch.bool).index_fill(0, samples, True)
    chance = torch.where(drawn, inclusion, 1 - inclusion).clamp(min=torch.finfo(inclusion.dtype).tiny)
    return sum_by(chance.log(), batch, n_meshes)

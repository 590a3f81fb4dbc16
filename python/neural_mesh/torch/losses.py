"""Losses of Sec. 3.4 and 4.4, with the names of docs/paper.md, and those added, in PyTorch's operators.

Probabilities and scores get gradients, positions where a term is smooth in them; which points or faces are near or in conflict is
constant. Squared lengths are in the unit of the points. Each function is for one mesh or a packed batch of meshes apart in space.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from ._nearest import nearest_to

from ._segments import sum_by, wide
from ._sampling import inclusion
from ._simplifier import Simplified
from ._graphs import edge_frame, in_edge_lengths, mesh_graph, triangle_graph

__all__ = [
    "PRINTED",
    "Objective",
    "closure",
    "collisions",
    "conflicts_by_count",
    "conflicts_by_pair",
    "coverage",
    "coverage_of_samples",
    "curvature_errors",
    "curvature_of_samples",
    "edge_crossings",
    "expected_cost",
    "forward_distance",
    "inclusion",
    "log_errors",
    "near_triangles",
    "objective_terms",
    "overlaps",
    "point_curvature",
    "probabilistic_chamfer",
    "quotient_agreement",
    "reverse_distance",
    "score_function",
    "smoothness",
    "spread_points",
    "surface_points",
    "total",
]


def _distance2(a: Any, b: Any) -> Any:
    return (a - b).square().sum(-1)


def _barycenters(points: Any, faces: Any) -> Any:
    return points[faces].mean(1)


def probabilistic_chamfer(points: Any, samples: Any, probabilities: Any) -> Any:
    """Computes Eq. (6) as printed: `sum_y p(y) min_x |x - y|^2 + sum_x p(y) min_y |x - y|^2`.

    In the second sum, y is the sample nearest to x. Its gradient moves mass away from badly covered samples.

    - `points`: n x 3; `samples`: n_samples x 3; `probabilities`: n_samples
    """
    to_points = _distance2(samples, points[nearest_to(points, samples, 1)[:, 0]])
    nearest = nearest_to(samples, points, 1)[:, 0]
    return (probabilities * to_points).sum() + (probabilities[nearest] * _distance2(points, samples[nearest])).sum()


def expected_cost(options: Any, costs: Any, cost_of_none: Any, probabilities: Any) -> Any:
    """Computes the mean over rows of `sum_k c_k p_k prod_{j<k} (1 - p_j) + c_none prod_j (1 - p_j)`: the first option kept counts.

    - `options`: n_rows x k, indices of probabilities, -1 for none; `costs`: n_rows x k; `cost_of_none`: n_rows
    """
    p = torch.where(options >= 0, probabilities[options.clamp(min=0)], 0)
    none_before = torch.cat([torch.ones_like(p[:, :1]), (1 - p).cumprod(1)], 1)
    return ((none_before[:, :-1] * p * costs).sum(1) + none_before[:, -1] * cost_of_none).mean()


def coverage_of_samples(points: Any, queries: Any, nearest: Any, inclusion: Any) -> Any:
    """Computes the expected squared distance from a query to its nearest sample, each point a sample with its inclusion probability.

    Divided by the mean of the last squared distances, which gives 0 to 1.

    - `points`: n x 3; `queries`: n_queries x 3; `nearest`: n_queries x k, from `nearest_to`; `inclusion`: n
    """
    return _relative_cost(nearest, _distance2(points[nearest], queries[:, None]), inclusion)


def _relative_cost(nearest: Any, costs: Any, inclusion: Any) -> Any:
    mean = costs[:, -1].mean()
    costs = costs / torch.where(mean > 0, mean, 1)
    return expected_cost(nearest, costs, costs[:, -1], inclusion)


def curvature_of_samples(of_queries: Any, of_points: Any, nearest: Any, inclusion: Any) -> Any:
    """Computes the expected squared difference in curvature between a query and its nearest sample, Sec. 4.4.

    Divided by the variance of the queries' curvature.

    - `of_queries`: n_queries; `of_points`: n, from `point_curvature`; others as for `coverage_of_samples`
    """
    variance = of_queries.var(unbiased=False)
    costs = (of_queries[:, None] - of_points[nearest]).square() * torch.where(variance > 0, 1 / variance, 0)
    return expected_cost(nearest, costs, costs[:, -1], inclusion)


def point_curvature(points: Any, k: int = 10) -> Any:
    """Computes the curvature of each point, `l0 / (l0 + l1 + l2)` of its neighbourhood's covariance, smoothed: n, 0 to 1/3.

    `points` is n x 3. Neighbourhoods are a point and its `k` nearest."""
    rows = nearest_to(points, points, min(k + 1, len(points)))
    offsets = wide(points[rows] - points[:, None])
    centered = offsets - offsets.mean(1, keepdim=True)
    spectrum = torch.linalg.eigvalsh(centered.transpose(1, 2) @ centered)
    trace = spectrum.sum(1)
    raw = torch.where(trace > 0, spectrum[:, 0] / torch.where(trace > 0, trace, 1), 0).clamp(0, 1 / 3)
    distances = offsets.norm(dim=2)
    deviation = distances.sum(1, keepdim=True) / max(rows.shape[1] - 1, 1)
    weights = torch.where(deviation > 0, (-0.5 * (distances / torch.where(deviation > 0, deviation, 1)).square()).exp(), 1)
    return ((weights * raw[rows]).sum(1) / weights.sum(1)).to(points.dtype)


def curvature_errors(points: Any, samples: Any, nearest: Any = None, of_points: Any = None) -> tuple[Any, Any]:
    """Computes the squared differences in curvature of points and nearest samples, n, and of samples and the points they are, n_samples.

    The sum of both means is the curvature error of Table 2, `curvature_error` of `neural_mesh.compare`.

    - `points`: n x 3; `samples`: n_samples, points that are drawn
    - `nearest`: nearest sample of each point, n, places in `samples`; found by default
    - `of_points`: n, from `point_curvature`; computed by default
    """
    drawn = points[samples]
    nearest = nearest_to(drawn, points, 1)[:, 0] if nearest is None else nearest
    of_points = point_curvature(points) if of_points is None else of_points
    of_samples = point_curvature(drawn)
    return (of_points - of_samples[nearest]).square(), (of_samples - of_points[samples]).square()


def smoothness(scores: Any, graph: Any) -> Any:
    """Computes the mean of `(s_i - s_j)^2` over the entries of a graph `[2, n_entries]`."""
    return (scores[graph[0]] - scores[graph[1]]).square().mean()


def forward_distance(points: Any, faces: Any, original: Any, probabilities: Any) -> Any:
    """Computes Eq. (7), `sum_b^ p_b^ min_b |b^ - b|^2`, divided by the number of candidates.

    - `points`: n x 3; `faces`: n_faces x 3; `original`: barycenters of the original faces
    """
    centers = _barycenters(points, faces)
    nearest = nearest_to(original, centers, 1)[:, 0]
    return (probabilities * _distance2(centers, original[nearest])).mean()


def reverse_distance(points: Any, faces: Any, original: Any, probabilities: Any, per_triangle: int = 10, k: int = 20) -> Any:
    """Computes Eq. (8) as printed, divided by the number of points y on the candidates.

    `sum_y p_y min_x |x - y|^2 + (1 - p_y) 1/k sum_k p_{t_k} |x_{t_k} - y|^2`, with p_y the probability of y's triangle, and its `k`
    nearest other triangles by barycenter

    - `original`: points of the original; `per_triangle`: points on each triangle, in a fixed pattern
    """
    own = torch.arange(len(faces), device=faces.device).repeat_interleave(per_triangle)
    ys = spread_points(points, faces, per_triangle).reshape(-1, 3)
    centers = _barycenters(points, faces)
    near = nearest_to(centers, ys, k + 1)
    is_other = (near != own[:, None]) & (near >= 0)
    # At most k others: the last one counts only where the own triangle is among the nearest.
    is_other &= is_other.cumsum(1) <= k
    p_near = probabilities[near.clamp(min=0)] * is_other
    replaced = (p_near * _distance2(centers[near.clamp(min=0)], ys[:, None])).sum(1) / is_other.sum(1).clamp(min=1)
    to_original = _distance2(ys, original[nearest_to(original, ys, 1)[:, 0]])
    p = probabilities[own]
    return (p * to_original + (1 - p) * replaced).mean()


# Steps of the pattern: inverse and squared inverse of the plastic number (Roberts 2018).
_STEP = (0.7548776662466927, 0.5698402909980533)


def spread_points(points: Any, faces: Any, n: int) -> Any:
    """Spreads `n` points evenly over each triangle, in a fixed pattern that starts at the barycenter: n_faces x n x 3."""
    order = torch.arange(n, device=points.device, dtype=torch.float64 if points.device.type != "mps" else torch.float32)
    u, v = ((1 / 3 + step * order).frac() for step in _STEP)
    u, v = (torch.where(u + v > 1, 1 - x, x).to(points.dtype)[:, None] for x in (u, v))
    a, b, c = (points[faces[:, corner]][:, None] for corner in range(3))
    return a + (b - a) * u + (c - a) * v


def surface_points(vertices: Any, faces: Any, n: int) -> Any:
    """Draws `n` points of a surface evenly, from torch's generator: n x 3."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    area = torch.linalg.cross(b - a, c - a).norm(dim=1).double().cumsum(0)
    picked = torch.searchsorted(area, torch.rand(n, device=area.device, dtype=area.dtype) * area[-1]).clamp(max=len(faces) - 1)
    u, v = torch.rand(2, n, 1, device=vertices.device, dtype=vertices.dtype)
    u, v = torch.where(u + v > 1, 1 - u, u), torch.where(u + v > 1, 1 - v, v)
    return a[picked] + (b - a)[picked] * u + (c - a)[picked] * v


def near_triangles(points: Any, faces: Any, surface: Any, k: int = 20) -> tuple[Any, Any]:
    """Finds the `k` triangles closest to each point of the original surface, among the 2 k with the nearest barycenters.

    Returns indices and squared distances, nearest first: n_points x k each, -1 and infinity where there are fewer."""
    near = nearest_to(_barycenters(points, faces), surface, 2 * k)
    corners = points[faces[near.clamp(min=0)]]
    distances = torch.where(near >= 0, _distance2_to_triangles(surface[:, None], corners), float("inf"))
    order = distances.detach().argsort(dim=1, stable=True)[:, : min(k, len(faces))]
    return near.gather(1, order), distances.gather(1, order)


def _distance2_to_triangles(x: Any, corners: Any) -> Any:
    """Returns the squared distance of points to triangles (`[..., 3, 3]`), by clamping to the nearest edge or the inside."""
    a, b, c = corners.unbind(-2)
    best = None
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        square = along.square().sum(-1)
        t = (((x - start) * along).sum(-1) / torch.where(square > 0, square, 1)).clamp(0, 1)
        to_edge = _distance2(x, start + t[..., None] * along)
        best = to_edge if best is None else torch.minimum(best, to_edge)
    normal = torch.linalg.cross(b - a, c - a)
    square = normal.square().sum(-1)
    height = ((x - a) * normal).sum(-1)
    sides = [(torch.linalg.cross(end - start, x - start) * normal).sum(-1) >= 0 for start, end in ((a, b), (b, c), (c, a))]
    is_over = sides[0] & sides[1] & sides[2] & (square > 0)
    return torch.where(is_over, height.square() / torch.where(square > 0, square, 1), best)


def coverage(near: tuple[Any, Any], penalty: Any, probabilities: Any) -> Any:
    """Computes the mean over the surface points of the expected squared distance to the nearest kept face.

    - `near`: from `near_triangles`; `penalty`: squared length, the cost of an uncovered point and the most of any
    """
    options, distances = near
    penalty = torch.as_tensor(penalty).to(distances)
    return expected_cost(options, torch.minimum(distances, penalty), penalty.expand(len(distances)), probabilities)


def closure(edges: Any, at_boundary: Any, probabilities: Any) -> Any:
    """Computes the expected number of edges with a wrong number of faces over that of edges with a face, each face kept independently.

    Wrong are one face or more than two on an inner edge, more than one on a boundary edge. The empty mesh is no minimum: 1.

    - `edges`: n_faces x 3, edges of each candidate; `at_boundary`: n_edges, true for edges that should have one face
    """
    n = len(at_boundary)
    edge, order = edges.reshape(-1).sort(stable=True)
    p = probabilities[torch.div(order, 3, rounding_mode="floor")]
    first = torch.searchsorted(edge, edge)
    place = torch.arange(len(edge), device=edge.device) - first
    none, one, two = p.new_ones(n), p.new_zeros(n), p.new_zeros(n)
    # The k-th face of every edge at once: the distribution of the number of kept faces, face by face.
    for k in range(int(place.max()) + 1 if len(place) else 0):
        here = (place == k).nonzero()[:, 0]
        q = p.new_zeros(n).index_copy(0, edge[here], p[here])
        none, one, two = none * (1 - q), one * (1 - q) + none * q, two * (1 - q) + one * q
    more = (1 - none - one - two).clamp(min=0)
    wrong, used = torch.where(at_boundary, two + more, one + more).sum(), (1 - none).sum()
    return torch.where(used > 0, wrong / used.clamp(min=1e-12), 1)


def quotient_agreement(labels: Any, probabilities: Any, balance: float = 0.5) -> Any:
    """Computes the weighted cross-entropy of probabilities and labels, in nats; `balance` 1 gives each class one half.

    `labels` are true where the mesh spans the candidate between three regions."""
    counts = torch.stack([(~labels).sum(), labels.sum()])
    weights = (1 - balance) / len(labels) + balance / ((counts > 0).sum() * counts.clamp(min=1))
    right = torch.where(labels, probabilities, 1 - probabilities).clamp(min=1e-4)
    return -(weights[labels.long()].to(right.dtype) * right.log()).sum()


def conflicts_by_count(conflicts: Any, probabilities: Any) -> Any:
    """Computes Eq. (9) as printed, `1/|F_s| sum_t p_t m(t)`; m(t) counts the pairs (t, u) of `conflicts`, `[2, n_pairs]`."""
    return probabilities[conflicts[0]].sum() / max(len(probabilities), 1)


def conflicts_by_pair(conflicts: Any, probabilities: Any) -> Any:
    """Computes `1/|F_s| sum_(t, u) p_t p_u`: the expected number of conflicts among kept faces, per candidate."""
    return (probabilities[conflicts[0]] * probabilities[conflicts[1]]).sum() / max(len(probabilities), 1)


def _both_ways(neighbours: Any, n: int) -> tuple[Any, Any]:
    rows, cols = neighbours
    keys = torch.unique(torch.cat([rows * n + cols, cols * n + rows]))
    return torch.div(keys, max(n, 1), rounding_mode="floor"), keys % max(n, 1)


def _volume(a: Any, b: Any, c: Any, d: Any) -> Any:
    return (torch.linalg.cross(b - a, c - a) * (d - a)).sum(-1)


def collisions(points: Any, faces: Any, neighbours: Any) -> Any:
    """Finds pairs (t, u) of nearby triangles where an edge of t passes through u, for Eq. (9): `[2, n_pairs]`.

    Contact, coplanar triangles and triangles with a common edge are no collisions. Signs are those of double precision.

    - `neighbours`: graph of nearby triangles (`triangle_graph` with `knn` above 0)
    """
    t, u = _both_ways(neighbours, len(faces))
    x = wide(points.detach())
    a, b, c = x[faces[u]].unbind(1)
    passes = torch.zeros_like(t, dtype=torch.bool)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        p, q = x[faces[t, start]], x[faces[t, end]]
        is_across = _volume(a, b, c, p) * _volume(a, b, c, q) < 0
        sides = torch.stack([_volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)])
        passes |= is_across & ((sides > 0).all(0) | (sides < 0).all(0))
    return torch.stack([t[passes], u[passes]])


def edge_crossings(points: Any, faces: Any, neighbours: Any, flatness: float = 0.1) -> Any:
    """Finds pairs (t, u) of nearby triangles whose edges cross, in both orders: `[2, n_pairs]`.

    Two edges without a common vertex cross if, projected along their common normal, they meet inside both, at a distance of at most
    `flatness` times the shorter edge."""
    t, u = _both_ways(neighbours, len(faces))
    x = wide(points.detach())
    found = torch.zeros_like(t, dtype=torch.bool)
    for e in ((0, 1), (1, 2), (2, 0)):
        for f in ((0, 1), (1, 2), (2, 0)):
            (i, j), (k, m) = (faces[t, e[0]], faces[t, e[1]]), (faces[u, f[0]], faces[u, f[1]])
            is_apart = (i != k) & (i != m) & (j != k) & (j != m)
            found |= is_apart & _segments_cross(x[i], x[j], x[k], x[m], flatness)
    return torch.stack([t[found], u[found]])


# Share of an edge's length at each end within which a meeting edge touches it instead of crossing.
_END = 1e-6


def _segments_cross(a: Any, b: Any, c: Any, d: Any, flatness: float) -> Any:
    along, across, between = b - a, d - c, c - a
    normal = torch.linalg.cross(along, across)
    area2, squares = normal.square().sum(-1), (along.square().sum(-1), across.square().sum(-1))
    is_parallel = area2 <= 1e-12 * squares[0] * squares[1]
    at = [(torch.linalg.cross(between, other) * normal).sum(-1) / torch.where(is_parallel, 1, area2) for other in (across, along)]
    is_inside = [(x > _END) & (x < 1 - _END) for x in at]
    is_flat = (between * normal).sum(-1).square() <= flatness**2 * torch.minimum(*squares) * area2
    return ~is_parallel & is_inside[0] & is_inside[1] & is_flat


# Smallest absolute cosine between the normals of nearly parallel triangles, and the rounding of summed areas.
_PARALLEL, _ROUNDING = 0.9, 1e-6


def overlaps(points: Any, faces: Any, neighbours: Any, per_triangle: int = 10, flatness: float = 0.1) -> Any:
    """Finds pairs (t, u) of nearby triangles where a test point of t lies over u: `[2, n_pairs]`.

    A point lies over a triangle if it is within `flatness` times the root of its area of its plane, and the areas that it spans with
    the corners sum to the triangle's. Pairs at more than 25 degrees are ignored."""
    t, u = _both_ways(neighbours, len(faces))
    x = wide(points.detach())
    a, b, c = x[faces].unbind(1)
    normal = torch.linalg.cross(b - a, c - a)
    area = normal.norm(dim=1)
    unit = normal / torch.where(area > 0, area, 1)[:, None]
    near = ((unit[t] * unit[u]).sum(1).abs() >= _PARALLEL).nonzero()[:, 0]
    t, u = t[near], u[near]
    ys = spread_points(x, faces, per_triangle)[t]
    height = ((ys - a[u, None]) * unit[u, None]).sum(-1)
    foot = ys - height[..., None] * unit[u, None]
    corners = [x[faces[u, corner], None] for corner in range(3)]
    sums = sum(torch.linalg.cross(p - foot, q - foot).norm(dim=-1) for p, q in zip(corners, corners[1:] + corners[:1], strict=True))
    is_over = (height.square() <= flatness**2 * area[u, None] / 2) & (sums <= area[u, None] * (1 + _ROUNDING))
    found = is_over.any(1) & (area[u] > 0)
    return torch.stack([t[found], u[found]])


def log_errors(areas: Any, distances: Any, turns: Any) -> Any:
    """Computes the logarithms of the mean distance, the mean normal error and the 8-norm of the distances: 3.

    - `areas`: weight of each point of the original; `distances`: to the result; `turns`: `1 - n.n'` of the normals there
    """
    unit = distances.detach().max().clamp(min=torch.finfo(distances.dtype).tiny)
    area = areas.sum()
    distance = (areas * distances).sum().clamp(min=1e-12 * area * unit)
    turn = (areas * turns).sum().clamp(min=1e-12 * area)
    peak = (distances / unit).pow(8).sum().clamp(min=1e-12)
    return torch.stack([(distance / area).log(), (turn / area).log(), unit.log() + peak.log() / 8])


def score_function(losses: Any, log_probability: Any, baseline: Any = 0.0) -> Any:
    """Returns a value whose gradient is the score function's: `mean((loss - baseline).detach() * log_probability)` (Williams 1992).

    `losses` and `log_probability` (of `Simplified`) have a number for each mesh; the baseline lowers the noise of the gradient."""
    return ((losses - baseline).detach() * log_probability).mean()


class Objective(NamedTuple):
    """Weights of Eq. (10) and of the terms added; terms of weight 0 are not computed. `PRINTED` is the paper's, empty mesh and all."""

    forward: float = 1.0
    """Eq. (7)."""
    reverse: float = 0.0
    """Eq. (8), as printed."""
    coverage: float = 1.0
    """Expected distance from the original to the kept faces."""
    closure: float = 1.0
    """Edges with a wrong number of faces."""
    collision: float = 0.1
    """Eq. (9)."""
    crossing: float = 0.1
    """Edge crossings."""
    overlap: float = 0.1
    """Overlaps."""
    agreement: float = 1.0
    """Cross-entropy with the triangles between three regions, as labels."""
    sampler: float = 1.0
    """Expected distance from vertices to the nearest sample; Eq. (6) as printed with `by_count`."""
    smoothness: float = 0.05
    """Squared differences of scores along edges."""
    by_count: bool = False
    """Conflicts and Eq. (6) as printed."""
    near_faces: int = 20
    """Faces nearest to each face, between which conflicts are looked for; and faces nearest to a point of the surface."""
    n_surface: int = 4
    """Points on the original surface, per sample."""


PRINTED = Objective(1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, True)


def objective_terms(result: Simplified, vertices: Any, faces: Any, objective: Objective = Objective()) -> dict[str, tuple[float, Any]]:
    """Computes the terms of Eq. (10) for a result of one mesh (vertices n x 3, faces m x 3): weight and value by name.

    Squared lengths are in units of the candidates' mean squared edge."""
    judged = result.candidates
    points, triangles, p = judged.points.detach(), judged.faces, judged.probabilities
    # The candidates' frame is that of the samples before they are placed: center and scale by the edges between regions.
    center, scale = edge_frame(result.points[result.samples].detach(), judged.between.edges)

    def place(x: Any) -> Any:
        return ((wide(x.detach()) - center) * scale[:, None]).to(points.dtype)

    corners = points[triangles]
    length2 = _distance2(corners, corners.roll(1, 1)).mean().clamp(min=1e-12) if len(triangles) else points.new_tensor(1.0)
    o = objective
    terms: dict[str, tuple[float, Any]] = {}
    graph = mesh_graph(faces.long(), len(vertices))
    if o.sampler:
        terms["sampler"] = (o.sampler, _sampler_term(result, vertices, graph, o))
    if o.smoothness:
        terms["smoothness"] = (o.smoothness, smoothness(result.scores, graph))
    if len(triangles) == 0:
        return terms
    if o.forward:
        terms["forward"] = (o.forward, forward_distance(points, triangles, place(_barycenters(vertices, faces)), p) / length2)
    if o.reverse or o.coverage:
        surface = place(surface_points(vertices.detach(), faces, o.n_surface * len(result.samples)))
    if o.reverse:
        terms["reverse"] = (o.reverse, reverse_distance(points, triangles, surface, p, k=o.near_faces) / length2)
    if o.coverage:
        terms["coverage"] = (o.coverage, coverage(near_triangles(points, triangles, surface, o.near_faces), length2, p) / length2)
    if o.closure:
        terms["closure"] = (o.closure, closure(judged.entries, _boundary_entries(result), p))
    if o.collision or o.crossing or o.overlap:
        near = triangle_graph(points, triangles, o.near_faces)
        cost = conflicts_by_count if o.by_count else conflicts_by_pair
        for name, weight, find in (("collision", o.collision, collisions), ("crossing", o.crossing, edge_crossings), ("overlap", o.overlap, overlaps)):
            if weight:
                terms[name] = (weight, cost(find(points, triangles, near), p))
    if o.agreement:
        terms["agreement"] = (o.agreement, quotient_agreement(judged.is_surface, p))
    return terms


def total(terms: dict[str, tuple[float, Any]]) -> Any:
    """Computes Eq. (10): the weighted sum of the terms."""
    return sum(weight * value for weight, value in terms.values())


# Vertices at which the sampler's term is measured, and neighbours of each: as a multiple of the vertices per sample, least, most.
_QUERIES, _NEIGHBOURS = 1024, (5.0, 8, 128)


def _sampler_term(result: Simplified, vertices: Any, graph: Any, objective: Objective) -> Any:
    points = in_edge_lengths(vertices.detach(), graph)
    if objective.by_count:
        chances = result.scores.softmax(0)
        return probabilistic_chamfer(points, points[result.samples], chances[result.samples])
    share, least, most = _NEIGHBOURS
    k = int(min(max(share * len(points) / len(result.samples), least), most))
    queries = points[torch.randint(len(points), (min(_QUERIES, len(points)),), device=points.device)]
    return coverage_of_samples(points, queries, nearest_to(points, queries, min(k, len(points))), result.inclusion)


def _boundary_entries(result: Simplified) -> Any:
    """Returns for each entry of G_ext whether exactly one triangle between regions has this edge."""
    judged = result.candidates
    counts = sum_by(judged.is_surface.long().repeat_interleave(3), judged.entries.reshape(-1), judged.graph.shape[1])
    return counts == 1

"""Smoothing of noisy points by moving least squares (Levin 1998, Alexa et al. 2003), differentiable by the points.

Constants are those of the library's `mesh-points`, which says why.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch
from torch.utils.checkpoint import checkpoint

from ._nearest import nearest_to
from ._segments import sum_by, wide

# Neighbours over which noise is looked for, and thickness of their layer, over its width, from which on a cloud is noisy.
_FEWEST, _NOISY = 12, 0.42
# Numbers of neighbours, of which the first is taken whose layer is nearly as thin as the thinnest, and reaches far enough.
_NEIGHBOURS, _NEARLY = (24, 48, 96, 192, 384), 1.1
# Thickness from which on neighbours are no layer but a ball, and least distance of the farthest neighbour, over the noise.
_SOLID, _REACH = 0.6, 3.0
# Points of each cloud whose layers are measured.
_PROBES = 1000
# Times that all points are smoothed, and rounds of each, in which points move along new normals.
_PASSES, _ROUNDS = 2, 3
# A neighbour's weight is exp(-_SHARPNESS d^2 / r^2), where r is the distance of the farthest one.
_SHARPNESS = 4.0
# Ridge on the curvatures, over the sum of the weights.
_RIDGE = 1e-4
# Neighbours that are handled at once.
_PART = 1 << 19


class _Layers(NamedTuple):
    """Layers of several numbers of neighbours (rows) around probes (columns)."""

    thickness: Any
    """Least spread over the middle one."""
    height: Any
    """Least spread."""
    reach: Any
    """Distance of the farthest neighbour."""
    cloud: Any
    """Cloud of each probe."""


def smooth_points(points: Any, batch: Any = None, neighbours: Any = None) -> Any:
    """Moves points to the quadratic surfaces that fit their neighbours, n x 3; clouds with hardly any noise stay.

    - `points`: n x 3
    - `batch`: cloud of each point, ascending; one by default
    - `neighbours`: number of nearest points for each cloud; by the noise by default, 0 for none
    """
    if neighbours is None:
        return smooth_noise(points, batch)[0]
    batch = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    # The point itself counts, too.
    neighbours = torch.as_tensor(neighbours, device=points.device).reshape(-1)
    return _smooth_over(points, batch, points, torch.ones_like(batch), batch, torch.where(neighbours > 0, neighbours + 1, 0))[0]


def smooth_noise(points: Any, batch: Any = None) -> tuple[Any, Any]:
    """Smooths noisy clouds; returns all points, and the mean number of points in a cube as wide as the noise, around each, n.

    Means of such cubes replace the points, so that neighbourhoods of dense and sparse points are as wide."""
    crowding = torch.ones(len(points), dtype=torch.float32, device=points.device)
    if len(points) == 0:
        return points, crowding
    batch = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    counts = torch.bincount(batch)
    layers = _layers(points, batch, (_FEWEST,))
    is_noisy = (counts >= _FEWEST) & (_median(layers.thickness[0], layers.cloud, len(counts)) >= _NOISY)
    own = is_noisy[batch].nonzero()[:, 0]
    if len(own) == 0:
        return points, crowding
    some, cloud = points[own], (is_noisy.cumsum(0) - 1)[batch[own]]
    for number in range(_PASSES):
        noise = _noise(some, cloud)
        means, sizes, owner = _cell_means(some, cloud, noise)
        some, crowds = _smooth_over(some, cloud, means, sizes, owner, _noise_neighbours(means, owner, noise))
        if number == 0:
            crowding = crowding.index_copy(0, own, crowds.float())
    return points.index_copy(0, own, some), crowding


def _smooth_over(points: Any, batch: Any, means: Any, sizes: Any, owner: Any, neighbours: Any) -> tuple[Any, Any]:
    """Moves points to the surfaces through the nearest means; returns them and the mean size of these means, n.

    - `points`: n x 3; `means`: m x 3, of `sizes` points each; `batch`, `owner`: their clouds; `neighbours`: means for each cloud
    """
    result, crowding = points, torch.ones_like(batch, dtype=wide(points).dtype)
    for k in neighbours.unique().tolist():
        own = (neighbours[batch] == k).nonzero()[:, 0] if k > 0 else batch[:0]
        if len(own) == 0:
            continue
        nearest, sources = nearest_to(means, points[own], k, owner, batch[own]), wide(means)
        step, moved, crowds = max(_PART // k, 1), [], []
        for part, some in zip(wide(points[own]).split(step), nearest.split(step), strict=True):
            weights = torch.where(some >= 0, sizes[some.clamp(min=0)], 0).to(part.dtype)
            crowds.append(weights.sum(1) / (some >= 0).sum(1))
            # Terms of all neighbours would not fit into memory, so gradients compute them again.
            if torch.is_grad_enabled() and points.requires_grad:
                moved.append(checkpoint(_project, part, sources, some, weights, use_reentrant=False))
            else:
                moved.append(_project(part, sources, some, weights))
        crowding = crowding.index_copy(0, own, torch.cat(crowds))
        result = result.index_copy(0, own, torch.cat(moved).to(points.dtype))
    return result, crowding


def _layers(points: Any, batch: Any, numbers: tuple[int, ...]) -> _Layers:
    counts = torch.bincount(batch, minlength=1)
    starts = counts.cumsum(0) - counts
    step = torch.div(counts + _PROBES - 1, _PROBES, rounding_mode="floor").clamp(min=1)
    probes = ((torch.arange(len(points), device=points.device) - starts[batch]) % step[batch] == 0).nonzero()[:, 0]
    positions = wide(points.detach())
    nearest = nearest_to(points, points[probes], numbers[-1], batch, batch[probes])
    spreads, reaches = [], []
    for k in numbers:
        some = nearest[:, :k]
        is_there = (some >= 0)[..., None]
        offsets = torch.where(is_there, positions[some.clamp(min=0)] - positions[probes, None], 0)
        number = is_there.sum(1, keepdim=True)
        centered = torch.where(is_there, offsets - offsets.sum(1, keepdim=True) / number, 0)
        spreads.append(torch.linalg.eigvalsh(centered.transpose(1, 2) @ centered / number).clamp(min=0).sqrt())
        reaches.append(offsets.norm(dim=2).amax(1))
    spread = torch.stack(spreads)
    return _Layers(spread[..., 0] / spread[..., 1].clamp(min=1e-300), spread[..., 0], torch.stack(reaches), batch[probes])


def _noise(points: Any, batch: Any) -> Any:
    """Returns the standard deviation of each cloud's noise, n_clouds: the median over the surface of the heights of layers.

    The layer of a probe is the first that doubling makes thicker. Balls of noise are no layers."""
    thickness, height, reach, cloud = _layers(points, batch, _NEIGHBOURS)
    thickens = torch.cat([thickness[1:] >= thickness[:-1], torch.ones_like(thickness[:1], dtype=torch.bool)])
    is_layer = (thickness < _SOLID) & thickens
    first = torch.where(is_layer.any(0), is_layer.to(torch.int8).argmax(0), thickness.argmin(0))
    # Probes are as dense as the points, so each is weighted by its area, the square of the reach.
    return _median(height.gather(0, first[None])[0], cloud, int(batch.max()) + 1, reach[0].square())


def _noise_neighbours(points: Any, batch: Any, noise: Any) -> Any:
    """Finds for each cloud the number of neighbours that smooth noise of a standard deviation, n_clouds.

    Noise makes layers of few neighbours as thick as wide, and the bends of the surface those of many: the layer is thinnest where the
    noise is averaged and the shape kept."""
    layers = _layers(points, batch, _NEIGHBOURS)
    thick, reach = (torch.stack([_median(row, layers.cloud, len(noise)) for row in rows]) for rows in (layers.thickness, layers.reach))
    fit = (thick <= _NEARLY * thick.amin(0)).to(torch.int8).argmax(0)
    far = (reach < _REACH * noise).sum(0).clamp(max=len(_NEIGHBOURS) - 1)
    return torch.tensor(_NEIGHBOURS, device=points.device)[torch.maximum(fit, far)]


def _cell_means(points: Any, batch: Any, noise: Any) -> tuple[Any, Any, Any]:
    """Returns the means of the points in each cube as wide as the cloud's noise, their numbers, and their clouds."""
    positions = wide(points)
    clouds3, least = batch[:, None].expand(-1, 3), positions.new_full((len(noise), 3), float("inf"))
    width = noise[batch, None]
    offsets = positions.detach() - least.scatter_reduce(0, clouds3, positions.detach(), "amin")[batch]
    own = torch.arange(len(points), device=points.device)[:, None]
    cells = torch.where(width > 0, (offsets / width.clamp(min=1e-300)).clamp(max=float(1 << 40)).long(), own)
    number = batch
    for axis in range(3):
        number = torch.unique(number * (cells[:, axis].max() + 1) + cells[:, axis], return_inverse=True)[1]
    sizes = torch.bincount(number)
    return sum_by(positions, number, len(sizes)) / sizes[:, None], sizes, torch.zeros_like(sizes).index_copy(0, number, batch)


def _median(values: Any, cloud: Any, n_clouds: int, weights: Any = None) -> Any:
    """Returns the value of each cloud at which half of the weights, 1 by default, is exceeded, n_clouds; 0 without values."""
    order = values.argsort(stable=True)
    order = order[cloud[order].argsort(stable=True)]
    weights = torch.ones_like(values) if weights is None else weights
    total = torch.zeros(n_clouds, dtype=values.dtype, device=values.device).index_add(0, cloud, weights)
    sums = weights[order].cumsum(0)
    places = torch.searchsorted(sums, total.cumsum(0) - 0.5 * total, right=True).clamp(max=len(order) - 1)
    return torch.where(torch.bincount(cloud, minlength=n_clouds) > 0, values[order[places]], 0)


def _project(moved: Any, means: Any, nearest: Any, weights: Any) -> Any:
    around = means[nearest.clamp(min=0)]
    for _ in range(_ROUNDS):
        moved = moved + _step_to_surface(around - moved[:, None], weights)
    return moved


def _step_to_surface(offsets: Any, sizes: Any) -> Any:
    """Returns the step from each point to the surface through its neighbours, n x 3.

    - `offsets`: n x k x 3 to the neighbours; `sizes`: n x k, the numbers of points that these stand for, 0 for none
    """
    squared = torch.where(sizes > 0, offsets.square().sum(2), 0)
    reach = squared.amax(1)
    reach = torch.where(reach > 0, reach, 1)
    weights = (sizes * (-_SHARPNESS * squared / reach[:, None]).exp())[..., None]
    total = weights.sum(1)
    center = (weights * offsets).sum(1) / total
    centered = offsets - center[:, None]
    normal = _least_direction((weights * centered).transpose(1, 2) @ centered / total[..., None])
    foot = (center * normal).sum(1, keepdim=True) * normal
    unit = reach.sqrt()[:, None]
    axis = torch.nn.functional.one_hot(normal.detach().abs().argmin(1), 3).to(normal.dtype)
    x = torch.linalg.cross(normal, axis)
    x = x / x.square().sum(1, keepdim=True).clamp(min=0.1).sqrt()
    frame = torch.stack([x, torch.linalg.cross(normal, x), normal], 2)
    height = _height((offsets - foot[:, None]) / unit[..., None] @ frame, weights)
    return foot + height * unit * normal


def _height(places: Any, weights: Any) -> Any:
    """Fits a quadratic to heights (third coordinate) over a plane, n x k x 3; returns its height at the origin, n x 1."""
    x, y, z = places.unbind(2)
    terms = torch.stack([x * x, x * y, y * y, x, y, torch.ones_like(x)], 2)
    weighted = (weights * terms).transpose(1, 2)
    ridge = torch.diag(terms.new_tensor([_RIDGE] * 3 + [0] * 3))
    matrix = weighted @ terms + weights.sum(1)[..., None] * ridge
    with torch.no_grad():
        factor, failed = torch.linalg.cholesky_ex(matrix)
        pivots = factor.diagonal(dim1=1, dim2=2).square() > 1e-12 * matrix.diagonal(dim1=1, dim2=2)
        is_sound = ((failed == 0) & pivots.all(1))[:, None]
    # Where points lie on a line, the height is 0, as of the identity with no right side.
    matrix = torch.where(is_sound[..., None], matrix, torch.eye(6, dtype=matrix.dtype, device=matrix.device))
    right = torch.where(is_sound, (weighted @ z[..., None])[..., 0], 0)
    return torch.cholesky_solve(right[..., None], torch.linalg.cholesky(matrix))[:, 5]


def _least_direction(covariance: Any) -> Any:
    """Returns the unit eigenvector of the least eigenvalue, n x 3, of either sign; zero where it is not single.

    It is that of a detached decomposition after a step of Rayleigh quotient iteration, so that first and second derivatives are exact, and
    finite where the two other eigenvalues are equal."""
    values, vectors = torch.linalg.eigh(covariance.detach())
    first, largest = vectors[:, :, 0], values[:, 2].clamp(min=1e-300)
    is_single = (values[:, 1] - values[:, 0] > 1e-9 * largest)[:, None]
    scaled = covariance / largest[:, None, None]
    quotient = torch.einsum("ni,nij,nj->n", first, scaled, first)
    a, b, c = (scaled - quotient[:, None, None] * torch.eye(3, dtype=scaled.dtype, device=scaled.device)).unbind(1)
    # The inverse times a number, which exists for singular matrices.
    adjugate = torch.stack([torch.linalg.cross(b, c), torch.linalg.cross(c, a), torch.linalg.cross(a, b)], 2)
    direction = torch.where(is_single, (adjugate @ first[..., None])[..., 0], first.new_tensor([1.0, 0.0, 0.0]))
    return torch.where(is_single, direction / direction.norm(dim=1, keepdim=True), 0)

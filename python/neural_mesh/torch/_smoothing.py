"""Smoothing of noisy points by moving least squares (Levin 1998, Alexa et al. 2003), differentiable by the points.

Constants are those of the library's `mesh-points`, which says why.
"""

from __future__ import annotations

from typing import Any

import torch
from torch.utils.checkpoint import checkpoint

from ._nearest import nearest_neighbours, nearest_to
from ._segments import wide

# Neighbours over which noise is looked for, and thickness of their layer, over its width, from which on a cloud is noisy.
_FEWEST, _NOISY = 12, 0.42
# Numbers of neighbours, of which the first is taken whose layer is nearly as thin as the thinnest, and how nearly.
_NEIGHBOURS, _NEARLY = (24, 48, 96, 192, 384), 1.1
# Points of each cloud whose layers are measured.
_PROBES = 1000
# Rounds in which points move along new normals.
_ROUNDS = 2
# A neighbour's weight is exp(-_SHARPNESS d^2 / r^2), where r is the distance of the farthest one.
_SHARPNESS = 4.0
# Ridge on the curvatures, over the sum of the weights.
_RIDGE = 1e-4
# Neighbours that are handled at once.
_PART = 1 << 19


def smooth_points(points: Any, batch: Any = None, neighbours: Any = None) -> Any:
    """Moves points to the quadratic surfaces that fit their neighbours, n x 3; clouds with hardly any noise stay.

    - `points`: n x 3
    - `batch`: cloud of each point, ascending; one by default
    - `neighbours`: number of nearest points for each cloud; by the noise by default, 0 for none
    """
    if len(points) == 0:
        return points
    batch = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    neighbours = noise_neighbours(points, batch) if neighbours is None else torch.as_tensor(neighbours, device=points.device).reshape(-1)
    result = points
    for k in neighbours.unique().tolist():
        own = (neighbours[batch] == k).nonzero()[:, 0] if k > 0 else batch[:0]
        if len(own) == 0:
            continue
        nearest, positions = nearest_neighbours(points[own], k, batch[own]), wide(points[own])
        parts = torch.arange(len(own), device=points.device).split(max(_PART // (k + 1), 1))
        # Terms of all neighbours would not fit into memory, so gradients compute them again.
        if torch.is_grad_enabled() and points.requires_grad:
            moved = [checkpoint(_project, positions, part, nearest[part], use_reentrant=False) for part in parts]
        else:
            moved = [_project(positions, part, nearest[part]) for part in parts]
        result = result.index_copy(0, own, torch.cat(moved).to(points.dtype))
    return result


def noise_neighbours(points: Any, batch: Any = None) -> Any:
    """Finds for each cloud the number of neighbours that smooth its noise, n_clouds; 0 if it has hardly any.

    Noise makes layers of few neighbours as thick as wide, and the bends of the surface those of many: the layer is thinnest where the
    noise is averaged and the shape kept."""
    batch = torch.zeros(len(points), dtype=torch.int64, device=points.device) if batch is None else batch
    counts = torch.bincount(batch, minlength=1)
    starts = counts.cumsum(0) - counts
    step = torch.div(counts + _PROBES - 1, _PROBES, rounding_mode="floor").clamp(min=1)
    probes = ((torch.arange(len(points), device=points.device) - starts[batch]) % step[batch] == 0).nonzero()[:, 0]
    positions, cloud = wide(points.detach()), batch[probes]
    nearest = nearest_to(points, points[probes], _NEIGHBOURS[-1], batch, cloud)
    fewest, *layers = (_thickness(positions, nearest[:, :k], cloud, len(counts)) for k in (_FEWEST, *_NEIGHBOURS))
    thick = torch.stack(layers, 1)
    first = (thick <= _NEARLY * thick.amin(1, keepdim=True)).to(torch.int8).argmax(1)
    is_noisy = (counts >= _FEWEST) & (fewest >= _NOISY)
    return torch.where(is_noisy, torch.tensor(_NEIGHBOURS, device=points.device)[first], 0)


def _thickness(positions: Any, nearest: Any, cloud: Any, n_clouds: int) -> Any:
    """Returns the median thickness, over the width, of the layers of neighbours in each cloud, n_clouds."""
    is_there = (nearest >= 0)[..., None]
    around = torch.where(is_there, positions[nearest.clamp(min=0)], 0)
    counts = is_there.sum(1, keepdim=True)
    centered = torch.where(is_there, around - around.sum(1, keepdim=True) / counts, 0)
    spread = torch.linalg.eigvalsh(centered.transpose(1, 2) @ centered).clamp(min=0).sqrt()
    ratios = spread[:, 0] / spread[:, 1].clamp(min=1e-300)
    order = ratios.argsort(stable=True)
    order = order[cloud[order].argsort(stable=True)]
    sizes = torch.bincount(cloud, minlength=n_clouds)
    middle = sizes.cumsum(0) - sizes + torch.div(sizes, 2, rounding_mode="floor")
    return torch.where(sizes > 0, ratios[order[middle.clamp(max=len(order) - 1)]], 0)


def _project(positions: Any, part: Any, nearest: Any) -> Any:
    around = positions[torch.cat([part[:, None], nearest.clamp(min=0)], 1)]
    is_there = torch.cat([torch.ones_like(part[:, None], dtype=torch.bool), nearest >= 0], 1)
    moved = positions[part]
    for _ in range(_ROUNDS):
        moved = moved + _step_to_surface(around - moved[:, None], is_there)
    return moved


def _step_to_surface(offsets: Any, is_there: Any) -> Any:
    """Returns the step from each point to the surface through its neighbours, n x 3, by their offsets (n x k x 3)."""
    squared = torch.where(is_there, offsets.square().sum(2), 0)
    reach = squared.amax(1)
    reach = torch.where(reach > 0, reach, 1)
    weights = torch.where(is_there, (-_SHARPNESS * squared / reach[:, None]).exp(), 0)[..., None]
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

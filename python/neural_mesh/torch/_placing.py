"""Placement of samples at the minima of their regions' quadrics (Garland and Heckbert 1997), differentiable by the vertices.

Constants are those of the library's option `--place`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from ._segments import sum_by, wide

# Pull of a vertex to its sample, over its quadric's trace.
_PULL = 1e-3
# Error added to that of each region, over the mean of all.
_LEAST_ERROR = 0.1
# Rounds in which vertices of turned faces return to their samples.
_ROUNDS = 4


class RegionQuadrics(NamedTuple):
    """Sums over each region of squared distances to planes of faces, about its sample."""

    samples: Any
    """Position of each sample, n_samples x 3, double."""
    steps: Any
    """From each sample to the minimum, n_samples x 3."""
    errors: Any
    """Values at the minima, n_samples."""


def region_quadrics(vertices: Any, surface: Any, regions: Any, samples: Any) -> RegionQuadrics:
    """Sums the quadrics of all regions; a face counts a third for the region of each corner.

    - `vertices`: n x 3; `surface`: m x 3, faces over them; `regions`: n, the sample (index into `samples`) of each vertex, -1 for none
    """
    positions = wide(vertices)
    origin = positions[samples]
    a, b, c = (positions[surface[:, corner]] for corner in range(3))
    normal = torch.linalg.cross(b - a, c - a)
    length = normal.square().sum(1)
    # The normal is twice the area long.
    normal = normal * torch.where(length > 0, length, 1).pow(-0.25)[:, None] / 6**0.5
    # No lines along boundaries: gaps between the triangles of a cloud would hold the samples.
    corners, through = torch.cat(surface.unbind(1)), torch.cat([a, a, a])
    forms = (normal[:, :, None] * normal[:, None, :]).repeat(3, 1, 1)
    rows = regions[corners]
    forms, through, rows = forms[rows >= 0], through[rows >= 0], rows[rows >= 0]
    offsets = through - origin[rows]
    pulls = (forms @ offsets[..., None])[..., 0]
    # A region of one sample would be summed in another order.
    matrix, right, constant = (sum_by(x, rows, len(samples) + 1)[:-1] for x in (forms, pulls, (pulls * offsets).sum(1)))
    trace = matrix.diagonal(dim1=1, dim2=2).sum(1)
    pull = torch.where(trace > 0, _PULL * trace, 1)[:, None].expand(-1, 3).diag_embed()
    steps = torch.linalg.solve(matrix + pull, right)
    errors = ((matrix @ steps[..., None])[..., 0] * steps).sum(1) - 2 * (right * steps).sum(1) + constant
    return RegionQuadrics(origin, steps, errors.clamp(min=0))


def score_gains(quadrics: RegionQuadrics, regions: Any, batch: Any, n_meshes: int) -> Any:
    """Returns a third of the logarithm of the remaining error of each vertex's region, over the mean of its mesh: n; no gradient.

    A region of width h leaves an error of about h^6, so that density changed by its cube root makes errors equal."""
    errors = quadrics.errors.detach()
    sums, counts = (sum_by(x, batch, n_meshes + 1) for x in (errors, torch.ones_like(errors)))
    mean = (sums / counts.clamp(min=1))[batch]
    gains = torch.where(mean > 0, (errors / torch.where(mean > 0, mean, 1) + _LEAST_ERROR).log() / 3, 0)
    return torch.where(regions >= 0, gains[regions.clamp(min=0)], 0)


def place_samples(quadrics: RegionQuadrics, faces: Any) -> Any:
    """Moves samples to the minima, unless faces (n_faces x 3, over the samples) would turn over: n_samples x 3, double."""
    origin, steps = quadrics.samples, quadrics.steps
    before, moved = origin.detach(), (origin + steps).detach()
    may_move = torch.ones(len(origin), dtype=torch.bool, device=origin.device)
    for _ in range(_ROUNDS):
        now = torch.where(may_move[:, None], moved, before)
        normals = [torch.linalg.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]) for x in (before, now)]
        may_move[faces[(normals[0] * normals[1]).sum(1) <= 0]] = False
    return origin + torch.where(may_move[:, None], steps, 0)

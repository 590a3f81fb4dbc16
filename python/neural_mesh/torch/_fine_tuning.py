"""Fine-tuning of one mesh's vertex scores by an error that is measured on draws, Sec. 4.4."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import torch

from .._native import NeuralMeshError
from . import losses
from ._graphs import in_edge_lengths, mesh_graph
from ._nearest import nearest_to
from ._packed import pack_meshes
from ._sampling import sample_counts
from ._segments import parts, sum_by
from ._simplifier import Simplifier

# Samples whose scores move together, and by how much. With ten samples, two meshes at 0.2 end at errors of 0.40 and 0.44, with five at 0.34
# and 0.36.
_CELL, _STEP = 5, 0.4
# Adam's step on a score, which falls to 0 by the square root of the steps that are left.
_RATE = 0.1
# Weight of a new draw in the running means of error and distance.
_FOLLOWING = 0.2
# The weight of the distance's logarithm is multiplied in each step by this power of its quotient over the bound, between two ends.
_GAIN, _WEIGHTS = 0.3, (0.1, 30.0)
# Pairs of a vertex and a sample up to which all distances take less time than a search: 4 to 25 times less for 12,000 vertices.
_MOST_PAIRS = 1 << 26
# Draws by which results are chosen, and shares of the way from the first scores to the last that are tried.
_CHECKS, _SHARES = 4, (1.0, 0.75, 0.5, 0.25)


class FineTuned(NamedTuple):
    """Scores of one mesh, and what they change."""

    scores: Any
    """Score of each vertex, n, for `simplifier(..., scores=...)`."""
    error: float
    """Error of draws by these scores over that by the Point Sampler's, at most 1."""
    distance: float
    """Mean squared distance from the vertices to the nearest sample, over that by the Point Sampler's scores."""


def fine_tune_scores(
    simplifier: Simplifier,
    vertices: Any,
    faces: Any,
    ratio: float | None = None,
    *,
    n_samples: int | None = None,
    objective: Callable[[Any, Any], tuple[Any, Any]] | None = None,
    most_distance: float = 1.1,
    steps: int = 60,
    seed: int = 0,
) -> FineTuned:
    """Finds scores by which draws of one mesh keep more of its curvature than by the Point Sampler's, at one size.

    In each step, the scores of cells of the surface are raised in one draw and lowered in another, at random. A cell's gradient is the
    change of the errors within it (simultaneous perturbation, Spall 1992). Draws of other seeds choose between the scores found and
    those on the way to them: the least error within the bound of distance.

    - `simplifier`: its Point Sampler gives the first scores, its `draw` the samples
    - `vertices`, `faces`: n x 3 and m x 3
    - `ratio`, `n_samples`: share of the vertices that become samples, or their number
    - `objective`: from samples (n_samples, vertices) and the nearest one of each vertex (n, places in the samples) to errors of the
      vertices and of the samples, of at least 0; the error is the sum of both means. `losses.curvature_errors` by default
    - `most_distance`: largest growth of the mean squared distance from the vertices to the nearest sample
    - `steps`: pairs of draws
    - `seed`: seed of draws and cells
    """
    mesh = _Drawn(simplifier, vertices, faces, ratio, n_samples, objective)
    first = mesh.first_scores()
    random = torch.Generator().manual_seed(seed)
    seeds = torch.randint(1 << 31, (_CHECKS,), generator=random)
    before = mesh.check(first, seeds)
    found = _descend(mesh, first, before, most_distance, steps, random) if steps > 0 and before[0] > 0 else first
    best = FineTuned(first, 1.0, 1.0)
    for share in _SHARES:
        scores = torch.lerp(first, found, share)
        error, distance = (after / was if was > 0 else 1.0 for after, was in zip(mesh.check(scores, seeds), before, strict=True))
        if error < best.error and distance <= most_distance:
            best = FineTuned(scores, error, distance)
    return best


class _Drawn:
    """One mesh, its draws and their errors."""

    def __init__(self, simplifier: Simplifier, vertices: Any, faces: Any, ratio: Any, n_samples: Any, objective: Any) -> None:
        self.vertices, self.faces, batch, n_meshes = packed = pack_meshes(vertices, faces, None)
        if n_meshes != 1 or self.faces is None:
            raise NeuralMeshError("fine_tune_scores: give vertices and faces of one mesh")
        if (ratio is None) == (n_samples is None):
            raise NeuralMeshError("give exactly one of ratio and n_samples")
        if ratio is not None and not 0 < ratio <= 1:
            raise NeuralMeshError(f"ratio: {ratio}: give a share above 0, at most 1")
        self.simplifier, self.packed = simplifier, packed
        self.n = len(self.vertices)
        self.graph = mesh_graph(self.faces, self.n)
        self.points = in_edge_lengths(self.vertices, self.graph, batch, 1).detach().to(simplifier.face_classifier.output.bias.dtype)
        self.counts = sample_counts(batch, 1, ratio, n_samples)
        self.objective = objective or self._curvature_errors
        self.curvature = None if objective else losses.point_curvature(self.vertices.detach())

    def _curvature_errors(self, samples: Any, nearest: Any) -> tuple[Any, Any]:
        return losses.curvature_errors(self.vertices.detach(), samples, nearest, self.curvature)

    @torch.no_grad()
    def first_scores(self) -> Any:
        return self.simplifier.point_sampler(self.points, self.graph, self.simplifier._normals(self.packed))

    @torch.no_grad()
    def draw(self, scores: Any, seeds: Any) -> Any:
        """Returns the samples of draws, each by scores of its own (n_draws x n): n_draws x n_samples."""
        n_draws, n = scores.shape
        batch = torch.arange(n_draws, device=scores.device).repeat_interleave(n)
        graph = torch.cat([self.graph + n * draw for draw in range(n_draws)], 1)
        points, counts = self.points.repeat(n_draws, 1), self.counts.repeat(n_draws)
        drawn = self.simplifier._draw_samples(points, graph, scores.reshape(-1), counts, batch, seeds.to(scores.device))
        return drawn.reshape(n_draws, -1) % n

    def nearest(self, samples: Any) -> Any:
        """Returns the nearest of samples for each vertex, n."""
        if len(samples) > _MOST_PAIRS // self.n:
            return nearest_to(self.points[samples], self.points, 1)[:, 0]
        # The points are centered, so that products of coordinates leave the small differences of distances their digits.
        drawn = self.points[samples]
        found = [torch.addmm(drawn.square().sum(1), self.points[part], -2 * drawn.T).argmin(1) for part in parts(self.n, len(drawn), drawn.device)]
        return torch.cat(found)

    @torch.no_grad()
    def measure(self, samples: Any) -> tuple[Any, Any]:
        """Returns each vertex's share of the error and of the mean squared distance: n each."""
        nearest = self.nearest(samples)
        of_vertices, of_samples = self.objective(samples, nearest)
        errors = (of_vertices / self.n).index_add(0, samples, (of_samples / len(samples)).to(of_vertices.dtype))
        return errors, (self.points - self.points[samples[nearest]]).square().sum(1) / self.n

    def check(self, scores: Any, seeds: Any) -> Any:
        """Returns the mean error and squared distance of draws."""
        drawn = self.draw(scores.expand(len(seeds), -1), seeds)
        return torch.tensor([[float(x.sum()) for x in self.measure(samples)] for samples in drawn], dtype=torch.float64).mean(0).tolist()


def _descend(mesh: _Drawn, first: Any, before: Any, most_distance: float, steps: int, random: Any) -> Any:
    """Returns the mean of the scores of the second half of the steps."""
    change, mean = torch.zeros_like(first), torch.zeros_like(first)
    optimizer = torch.optim.Adam([change], lr=_RATE)
    running, weight = torch.tensor(before), 1.0
    samples = mesh.draw(first[None], torch.randint(1 << 31, (1,), generator=random))[0]
    for step in range(steps):
        # Centers among the samples of a draw give cells of about equally many samples.
        order = torch.randperm(len(samples), generator=random).to(samples.device)
        n_cells = max(len(samples) // _CELL, 1)
        cell = mesh.nearest(samples[order[:n_cells]])
        sign = (2 * torch.randint(2, (n_cells,), generator=random) - 1).to(first)
        moves = torch.stack([_STEP * sign[cell], -_STEP * sign[cell]])
        drawn = mesh.draw(first + change + moves, torch.randint(1 << 31, (2,), generator=random))
        costs = [mesh.measure(samples) for samples in drawn]
        samples = drawn[step % 2]
        now = torch.tensor([[float(x.sum()) for x in cost] for cost in costs]).mean(0)
        running = running + _FOLLOWING * (now - running)
        excess = float(running[1]) / before[1] / most_distance if before[1] > 0 else 1.0
        weight = min(max(weight * excess**_GAIN, _WEIGHTS[0]), _WEIGHTS[1])
        up, down = (errors / float(running[0]) + weight * distances / max(float(running[1]), 1e-300) for errors, distances in costs)
        slope = sum_by(up - down, cell, n_cells) * sign / (2 * _STEP)
        # Samples that a cell gains are taken from all others, at the mean slope of a sample.
        share = torch.bincount(cell[drawn.reshape(-1)], minlength=n_cells) / drawn.numel()
        slope = slope - share * slope.sum()
        # Adam takes no account of a gradient's size, so that a cell's vertices may share its slope evenly.
        change.grad = (slope / torch.bincount(cell, minlength=n_cells).clamp(min=1))[cell].to(change.dtype)
        for group in optimizer.param_groups:
            group["lr"] = _RATE * (1 - step / steps) ** 0.5
        optimizer.step()
        if step >= steps // 2:
            mean += (first + change) / (steps - steps // 2)
    return mean

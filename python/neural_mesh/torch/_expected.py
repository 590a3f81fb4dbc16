"""Estimates in PyTorch the expected error of a result and its gradient by the vertex scores."""

from __future__ import annotations

from typing import Any

import torch

from .. import _native
from .._learn import Objective, judge
from .._meshes import read_input
from ._arrays import as_numpy


def expected(
    objective: Objective,
    vertices: Any,
    faces: Any,
    scores: torch.Tensor,
    *,
    ratio: float,
    probes: int = 4,
    cell: int = 10,
    step: float = 0.4,
    seed: int = 0,
    threads: int | None = None,
    with_variance: bool = False,
) -> Any:
    """Estimates the mean of `objective(original, result)` under perturbed scores: a scalar, differentiable by `scores`.

    The gradient comes from simultaneous perturbation (Spall 1992), so the objective need not be differentiable.

    - `objective`: returns a number of at least 0, or one per vertex or face of the original, which are summed with less noise
    - `vertices`, `faces`: the original, n x 3 and m x 3
    - `scores`: n, logarithms of vertex importance; only differences matter
    - `ratio`: share of the vertices that results keep
    - `probes`: pairs of results to make
    - `cell`: result vertices per surface cell whose scores move together
    - `step`: amount by which scores move up or down
    - `seed`: seed of the perturbations; take a new one for each step of an optimizer
    - `threads`: one per core by default
    - `with_variance`: returns a pair, with the variance of each entry of the gradient (n) second
    """
    source = read_input((vertices, faces), None, None)
    score_values = as_numpy(scores, torch.float32).reshape(-1)
    settings = f"probes = {int(probes)}\nprobe_cell = {int(cell)}\nprobe_step = {float(step)!r}\n"
    found = _native.estimate(source.arrays, score_values, float(ratio), judge(objective), settings, int(seed), threads)
    mean, gradient, variance = found
    of_scores = [torch.from_numpy(array).to(scores.device, scores.dtype).reshape(scores.shape) for array in (gradient, variance)]
    value = _Expected.apply(scores, scores.new_tensor(mean), of_scores[0])
    return (value, of_scores[1]) if with_variance else value


class _Expected(torch.autograd.Function):
    """A precomputed scalar with its gradient."""

    @staticmethod
    def forward(ctx: Any, scores: torch.Tensor, mean: torch.Tensor, gradient: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(gradient)
        return mean.clone()

    @staticmethod
    def backward(ctx: Any, *outer: Any) -> tuple[Any, None, None]:
        (gradient,) = ctx.saved_tensors
        return outer[0] * gradient, None, None

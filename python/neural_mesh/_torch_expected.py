"""What an objective of results is expected to be, as a function of the importance of the vertices, with its gradient, in PyTorch."""

from __future__ import annotations

from typing import Any

import torch

from . import _native
from ._learn import Objective, judge
from ._meshes import given
from ._torch_arrays import as_numpy


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
    """The mean of `objective(original, result)` over results whose scores were moved up and down: a scalar, differentiable by
    `scores` (n, logarithms of the importance of the vertices; only differences matter).

    The objective need not be differentiable: cells of the surface, of about `cell` vertices of the result, are moved by `step`, up or
    down at random, and are credited with what changes (simultaneous perturbation, Spall 1992), as in `train`. It gives a number of at
    least 0, or one for each vertex or face of the original, whose sum counts: with places the gradient is less noisy.
    `probes` pairs of results are made; `seed` says which, so another one for each step. `with_variance` gives the variance of each
    entry of the gradient as well, n.
    """
    source = given((vertices, faces), None, None)
    moved = as_numpy(scores, torch.float32).reshape(-1)
    settings = f"probes = {int(probes)}\nprobe_cell = {int(cell)}\nprobe_step = {float(step)!r}\n"
    found = _native.estimate(source.arrays, moved, float(ratio), judge(objective), settings, int(seed), threads)
    mean, gradient, variance = found
    of_scores = [torch.from_numpy(array).to(scores.device, scores.dtype).reshape(scores.shape) for array in (gradient, variance)]
    value = _Expected.apply(scores, scores.new_tensor(mean), of_scores[0])
    return (value, of_scores[1]) if with_variance else value


class _Expected(torch.autograd.Function):
    """A number that is known, with its gradient."""

    @staticmethod
    def forward(ctx: Any, scores: torch.Tensor, mean: torch.Tensor, gradient: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(gradient)
        return mean.clone()

    @staticmethod
    def backward(ctx: Any, *outer: Any) -> tuple[Any, None, None]:
        (gradient,) = ctx.saved_tensors
        return outer[0] * gradient, None, None

"""Fine-tunes the scores of meshes to their curvature (Sec. 4.4), one mesh at a time, and measures draws of other seeds.

python fine_tune.py spot.ply [MESH...] [--ratios 0.05 0.1 0.2] [--draw multinomial] [--steps 60] [--most-vertices 12000]

Figures are those by the scores found over those by the Point Sampler's, means of eight draws: the curvature error of Table 2, and CD, the
mean squared distance from the vertices to the nearest sample.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch

import neural_mesh as nm
import neural_mesh.torch as nmt
from neural_mesh.torch import losses

SEEDS = range(50, 58)


@torch.no_grad()
def measure(layer: Any, vertices: Any, faces: Any, ratio: float, scores: Any) -> Any:
    """Returns curvature error and CD of results, means over the seeds."""
    rows = []
    for seed in SEEDS:
        samples = layer(vertices, faces, ratio, scores=scores, seed=seed).samples
        nearest = nmt.nearest_to(vertices[samples], vertices, 1)[:, 0]
        errors = losses.curvature_errors(vertices, samples, nearest)
        rows.append([float(sum(x.mean() for x in errors)), float((vertices - vertices[samples[nearest]]).square().sum(1).mean())])
    return np.mean(rows, 0)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("meshes", type=Path, nargs="+")
    arguments.add_argument("--ratios", type=float, nargs="+", default=[0.05, 0.1, 0.2])
    arguments.add_argument("--draw", choices=("scattered", "multinomial"), default="scattered")
    arguments.add_argument("--steps", type=int, default=60)
    arguments.add_argument("--most-vertices", type=int, default=12_000, help="larger meshes are left out")
    given = arguments.parse_args()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    layer = nmt.Simplifier.from_weights("paper-open", draw=given.draw).to(device)
    rows: dict[float, list[Any]] = {ratio: [] for ratio in given.ratios}
    for path in given.meshes:
        light = nm.simplify(path, ratio=1.0)
        if len(light.vertices) > given.most_vertices:
            continue
        vertices, faces = (torch.tensor(np.asarray(x), device=device) for x in light)
        vertices, faces = vertices.float(), faces.long()
        for ratio in given.ratios:
            start = time.perf_counter()
            found = nmt.fine_tune_scores(layer, vertices, faces, ratio, steps=given.steps)
            spent = time.perf_counter() - start
            before, after = (measure(layer, vertices, faces, ratio, scores) for scores in (None, found.scores))
            rows[ratio].append(after / before)
            error, distance = after / before
            print(f"{path.name}, {len(vertices)} vertices, {ratio}: error {error:.3f}, CD {distance:.3f}, {spent:.1f} s", flush=True)
    for ratio, quotients in rows.items():
        if quotients:
            (error, distance), worst = np.median(quotients, 0), np.max(quotients, 0)
            said = f"medians of {len(quotients)}: error {error:.2f}, CD {distance:.2f}; largest {worst[0]:.2f}, {worst[1]:.2f}"
            print(f"ratio {ratio}, {said}")


if __name__ == "__main__":
    main()

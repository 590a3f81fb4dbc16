"""Trains the paper's network end to end with the layer `neural_mesh.torch.Simplifier`, on a processor or a GPU.

python train_layer.py --out mine.safetensors                        # on generated meshes, in a minute
python train_layer.py --data meshes --held-out cat dog --epochs 150 --out mine.safetensors

Meshes are all files of the folder that `neural_mesh.simplify` reads. Those whose names begin with a word of `--held-out` are only
measured: the distance between their surface and that of results, over the mean edge, and the share of edges without two faces.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import torch

import neural_mesh as nm
import neural_mesh.torch as nmt
from neural_mesh.torch import losses

Mesh = tuple[Any, Any]


def generated(seed: int) -> Mesh:
    """Returns a bumpy torus of 1,600 faces."""
    n, m, random = 40, 20, np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    waves = random.integers(1, 7, 2)
    r = random.uniform(0.2, 0.5) + random.uniform(0.02, 0.1) * np.sin(waves[0] * u) * np.cos(waves[1] * v)
    points = np.stack([(1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b, c, d = (((i + di) % n * m + (j + dj) % m).reshape(-1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return torch.from_numpy(points + random.normal(scale=2e-3, size=points.shape)).float(), torch.from_numpy(faces)


def read_meshes(folder: Path | None, held_out: list[str], most: int) -> tuple[list[Mesh], list[Mesh]]:
    if folder is None:
        return [generated(seed) for seed in range(8)], [generated(seed) for seed in (100, 101)]
    training, validation = [], []
    for path in sorted(folder.iterdir()):
        vertices, faces = nm.simplify(path, vertices=most)
        mesh = torch.from_numpy(np.asarray(vertices, np.float32)), torch.from_numpy(np.asarray(faces, np.int64))
        (validation if path.name.startswith(tuple(held_out)) else training).append(mesh)
    return training, validation


def turned(vertices: Any) -> Any:
    """Rotates at random, and stretches by up to a tenth along each axis."""
    q, _ = torch.linalg.qr(torch.randn(3, 3, device=vertices.device))
    return vertices @ q * torch.empty(3, device=vertices.device).uniform_(-0.1, 0.1).exp()


@torch.no_grad()
def measure(layer: Any, meshes: list[Mesh], ratio: float) -> tuple[float, float]:
    """Returns the two-sided mean distance over the mean edge, and the share of edges without two faces, means over the meshes."""
    rows = []
    for at, (v, f) in enumerate(meshes):
        result = layer(v, f, ratio, seed=at)
        if len(result.faces) == 0:
            return float("inf"), 1.0
        clouds = [losses.surface_points(*mesh, 20_000) for mesh in ((v, f), (result.vertices, result.faces))]
        distance = sum((a - b[nmt.nearest_to(b, a, 1)[:, 0]]).norm(dim=1).mean() for a, b in (clouds, clouds[::-1]))
        edges = result.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).sort(1).values
        counts = torch.unique(edges, dim=0, return_counts=True)[1]
        length = (v[f] - v[f.roll(1, 1)]).norm(dim=2).mean()
        rows.append([float(distance / length), float((counts != 2).float().mean())])
    return tuple(np.mean(rows, 0))


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--data", type=Path)
    arguments.add_argument("--held-out", nargs="*", default=[])
    arguments.add_argument("--out", type=Path)
    arguments.add_argument("--init", help="weights to start from")
    arguments.add_argument("--epochs", type=int, default=10)
    arguments.add_argument("--rate", type=float, default=1e-3)
    arguments.add_argument("--vertices", type=int, default=2000, help="larger meshes are simplified to so many")
    arguments.add_argument("--gradient", choices=("straight-through", "score", "none"), default="straight-through")
    arguments.add_argument("--printed", action="store_true", help="the losses as the paper prints them, which end with an empty mesh")
    arguments.add_argument("--seed", type=int, default=0)
    given = arguments.parse_args()
    torch.manual_seed(given.seed)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    training, validation = ([(v.to(device), f.to(device)) for v, f in x] for x in read_meshes(given.data, given.held_out, given.vertices))
    gradient = "none" if given.gradient == "score" else given.gradient
    layer = nmt.Simplifier.from_weights(given.init, gradient=gradient) if given.init else nmt.Simplifier(gradient=gradient)
    layer.to(device)
    optimizer = torch.optim.Adam(layer.parameters(), lr=given.rate)
    decay = torch.optim.lr_scheduler.ExponentialLR(optimizer, 0.99)
    objective, baseline = losses.PRINTED if given.printed else losses.Objective(), None
    for epoch in range(given.epochs):
        sums: dict[str, float] = {}
        for at in torch.randperm(len(training)).tolist():
            vertices, faces = turned(training[at][0]), training[at][1]
            result = layer(vertices, faces, ratio=0.05 * 10 ** float(torch.rand(())))
            terms = losses.objective_terms(result, vertices, faces, objective)
            loss = losses.total(terms)
            if given.gradient == "score":
                baseline = loss.detach() if baseline is None else 0.9 * baseline + 0.1 * loss.detach()
                loss = loss + losses.score_function(loss[None], result.log_probability / len(result.samples), baseline)
            optimizer.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(layer.parameters(), 1.0)
            optimizer.step()
            sums = {name: sums.get(name, 0.0) + float(value.detach()) / len(training) for name, (_, value) in terms.items()}
        decay.step()
        print(f"epoch {epoch + 1}: " + ", ".join(f"{name} {value:.4f}" for name, value in sums.items()), flush=True)
    if validation:
        print("held out, ratio 0.1: distance {:.4f} edges, open edges {:.2%}".format(*measure(layer, validation, 0.1)))
    if given.out:
        layer.save(given.out)


if __name__ == "__main__":
    main()

"""Measures the layer `neural_mesh.torch.Simplifier` on a GPU, or else on the processor against the library.

python layer_times.py [--faces 200000 2000000] [--ratio 0.1] [--device cuda] [--threads 1]

Meshes are bumpy tori. Times are medians of five runs without gradients, after two to warm up; on the processor, of processor time in
one run after one.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch

import neural_mesh.torch as nmt
from neural_mesh import _native


def torus(n_faces: int) -> tuple[Any, Any]:
    """Returns a bumpy torus of about so many faces."""
    m = int((n_faces / 4) ** 0.5)
    n = n_faces // (2 * m)
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    r = 0.3 + 0.03 * np.sin(5 * u) * np.cos(3 * v)
    points = np.stack([(1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], -1).reshape(-1, 3)
    points += np.random.default_rng(1).normal(scale=2e-4, size=points.shape)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b, c, d = (((i + di) % n * m + (j + dj) % m).reshape(-1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return points.astype(np.float32), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int64)


def seconds_on_gpu(run: Any) -> float:
    times = []
    for at in range(7):
        torch.cuda.synchronize()
        start = time.perf_counter()
        run()
        torch.cuda.synchronize()
        if at >= 2:
            times.append(time.perf_counter() - start)
    return statistics.median(times)


def seconds_of_processor(run: Any) -> float:
    run()
    start = time.process_time()
    run()
    return time.process_time() - start


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--faces", type=int, nargs="+", default=[200_000, 2_000_000])
    arguments.add_argument("--ratio", type=float, default=0.1)
    arguments.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    arguments.add_argument("--threads", type=int, default=1)
    given = arguments.parse_args()
    device = torch.device(given.device)
    torch.set_num_threads(given.threads)
    print(torch.cuda.get_device_name() if device.type == "cuda" else f"processor, {given.threads} threads", torch.__version__)
    layer = nmt.Simplifier.from_weights("paper-open").to(device).eval()
    for n_faces in given.faces:
        points, corners = torus(n_faces)
        vertices, faces = torch.from_numpy(points).to(device), torch.from_numpy(corners).to(device)

        def run() -> Any:
            with torch.no_grad():
                return layer(vertices, faces, given.ratio, seed=1)  # noqa: B023

        if device.type == "cuda":
            torch.cuda.reset_peak_memory_stats()
            spent = f"{1e3 * seconds_on_gpu(run):.1f} ms, {torch.cuda.max_memory_allocated() / 1e9:.2f} GB"
        else:
            file = Path(__file__).resolve().parents[2] / "crates/network/weights/paper-open.safetensors"
            n_samples = int(given.ratio * len(points))
            ours = seconds_of_processor(run)
            theirs = seconds_of_processor(lambda: _native.paper_stages(points, corners, n_samples, file.read_bytes(), 1, given.threads))
            spent = f"layer {ours:.2f} s, library {theirs:.3f} s, ratio {ours / theirs:.1f}"
        result = run()
        print(f"{len(corners)} faces to {len(result.faces)}: {spent}", flush=True)


if __name__ == "__main__":
    main()

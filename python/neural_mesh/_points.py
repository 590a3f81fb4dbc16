"""Meshes point clouds with the paper's network."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _native
from ._meshes import convert_like, points_of
from ._options import Number, Path, Progress, Whole, n_threads, plain
from ._result import Light


def mesh_points(
    cloud: Any,
    *,
    ratio: Number | str | None = None,
    vertices: Whole | str | None = None,
    keep_points: bool = False,
    out: Path | None = None,
    weights: Path | None = None,
    seed: Whole = 0,
    threads: Whole | None = None,
    progress: Progress | None = None,
    format: str | None = None,
    force: bool = False,
) -> Light[Any]:
    """Meshes a point cloud with the paper's network; the result is a manifold, with holes only where points are missing.

    - `cloud`: the path of a file, an array of points (n x 3), or an object with `points` or `vertices`
    - `ratio`, `vertices`: share or number of the points that become vertices; all by default
    - `keep_points`: keeps vertices at their points; otherwise noise is smoothed, and fewer vertices than points are placed
    - `out`, `format`, `force`: path and format of the file to write; `force` replaces an existing one
    - `weights`: file of a network; the shipped one by default
    - `seed`, `threads`, `progress`: as in `simplify`

    Raises `OptionError` if both sizes are given, and `NeuralMeshError` if the points cannot be read.
    """
    if ratio is not None and vertices is not None:
        raise _native.OptionError("ratio and vertices: give one of them")
    path, points = points_of(cloud)
    meshed = _native.mesh_points(
        path or "cloud",
        points,
        ratio=plain(ratio),
        vertices=plain(vertices),
        keep_points=keep_points,
        out=None if out is None else os.fspath(out),
        format=format,
        weights=None if weights is None else os.fspath(weights),
        seed=int(seed),
        force=force,
        threads=n_threads(threads),
        progress=progress,
    )
    pair = (convert_like(cloud, meshed.vertices), convert_like(cloud, meshed.faces))
    report = {"outcome": "reached", **json.loads(meshed.report)}
    written = () if out is None else (os.fspath(out),)
    sources = np.asarray(meshed.sources)
    return Light(*pair, {}, None, None, {}, {}, report, None, sources, written, pair)  # type: ignore[arg-type]

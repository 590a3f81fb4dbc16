"""`mesh_points`: a cloud of points becomes a mesh over some or all of them."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _native
from ._meshes import alike, points_of
from ._options import Number, Path, Progress, Whole, n_threads, plain
from ._result import Light


def mesh_points(
    cloud: Any,
    *,
    ratio: Number | str | None = None,
    vertices: Whole | str | None = None,
    out: Path | None = None,
    weights: Path | None = None,
    seed: Whole = 0,
    threads: Whole | None = None,
    progress: Progress | None = None,
    format: str | None = None,
    force: bool = False,
) -> Light[Any]:
    """Meshes a point cloud with the network: a file, points n x 3, or what has points. `ratio` or `vertices` say how many of the
    points become vertices, by default all. Vertices are points; the result may have holes."""
    if ratio is not None and vertices is not None:
        raise _native.OptionError("ratio and vertices: give one of them")
    path, points = points_of(cloud)
    meshed = _native.mesh_points(
        path or "cloud",
        points,
        ratio=plain(ratio),
        vertices=plain(vertices),
        out=None if out is None else os.fspath(out),
        format=format,
        weights=None if weights is None else os.fspath(weights),
        seed=int(seed),
        force=force,
        threads=n_threads(threads),
        progress=progress,
    )
    pair = (alike(cloud, meshed.vertices), alike(cloud, meshed.faces))
    report = {"outcome": "reached", **json.loads(meshed.report)}
    written = () if out is None else (os.fspath(out),)
    sources = np.asarray(meshed.sources)
    return Light(*pair, {}, None, None, {}, {}, report, None, sources, written, mesh=pair)  # type: ignore[arg-type]

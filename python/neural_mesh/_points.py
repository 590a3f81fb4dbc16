"""`mesh_points`: a cloud of points becomes a mesh over some or all of them."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _native
from ._meshes import alike, points_of
from ._result import Light
from ._simplify import Progress


def mesh_points(
    cloud: Any,
    *,
    ratio: float | str | None = None,
    vertices: int | str | None = None,
    out: str | os.PathLike[str] | None = None,
    weights: str | os.PathLike[str] | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    format: str | None = None,
    force: bool = False,
) -> Light:
    """Meshes a point cloud with the network: a file, points n x 3, or what has points. `ratio` or `vertices` say how many of the
    points become vertices, by default all. Vertices are points; the result may have holes."""
    if ratio is not None and vertices is not None:
        raise _native.OptionError("ratio and vertices: give one of them")
    path, points = points_of(cloud)
    meshed = _native.mesh_points(
        path or "cloud",
        points,
        ratio=ratio,
        vertices=vertices,
        out=None if out is None else os.fspath(out),
        format=format,
        weights=None if weights is None else os.fspath(weights),
        seed=seed,
        force=force,
        threads=threads,
        progress=progress,
    )
    pair = (alike(cloud, meshed.vertices), alike(cloud, meshed.faces))
    report = {"outcome": "reached", **json.loads(meshed.report)}
    written = () if out is None else (os.fspath(out),)
    sources = np.asarray(meshed.sources)
    return Light(*pair, {}, None, None, {}, report, None, sources, written, mesh=pair)

"""`simplify` and `lods`: what people give, to options and arrays; what comes back, to the type that was given."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._meshes import Given, given
from ._options import as_json
from ._result import Light, Map, NotReachedError

Progress = Callable[[float, str], object]


def simplify(
    mesh: Any,
    *,
    ratio: float | str | None = None,
    vertices: int | str | None = None,
    faces: int | str | None = None,
    error: float | str | None = None,
    size: int | str | None = None,
    out: str | os.PathLike[str] | None = None,
    attributes: Mapping[str, ArrayLike] | None = None,
    groups: ArrayLike | None = None,
    importance: str | ArrayLike | None = None,
    lock_boundaries: bool = False,
    subset: bool = False,
    close: bool = False,
    keep_features: bool = False,
    crease_angle: float | None = None,
    seam_error: float | None = None,
    keep_components: bool = False,
    prune: bool | float | str = False,
    hidden: Literal["keep", "cheap", "drop"] | None = None,
    for_: Literal["shape", "poses", "spectrum"] | None = None,
    fill_holes: bool | int = False,
    printable: bool | float | str = False,
    weld: bool | float | str = True,
    symmetric: bool | str = False,
    ignore: Sequence[Literal["uv", "normals", "colors", "materials"]] | None = None,
    map: bool = False,
    optimize: Literal["balanced", "mean", "max", "normals"] | None = None,
    effort: Literal["fast", "standard", "best"] | None = None,
    scores: Literal["bending", "network", "geometry"] | None = None,
    assembly: Literal["closed", "paper"] | None = None,
    weights: str | os.PathLike[str] | None = None,
    seed: int = 0,
    strict: bool = False,
    check: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
    format: str | None = None,
    force: bool = False,
    picture: str | os.PathLike[str] | None = None,
    report: str | os.PathLike[str] | None = None,
    allow_outside: bool = False,
) -> Light:
    """Makes a mesh lighter. Exactly one of `ratio`, `vertices`, `faces`, `error` and `size` says what stays: numbers, or
    what the program takes, as `"10%"`, `"10k"`, `"2MB"`.

    `mesh` is a file, a pair of arrays (vertices n x 3, faces m x 3), or a mesh of trimesh, Open3D or pyvista. With `out` the
    result is written as the program writes it. Options are the program's (`neural-mesh simplify --help`, `docs/python.md`).

    Raises `NeuralMeshError` where there is no result, and `NotReachedError` where it is not as asked.
    """
    options = locals()
    target = _one_size({name: options[name] for name in _SIZES})
    return _results(mesh, target, options)[0]


def lods(mesh: Any, ratios: Sequence[float | str], **options: Any) -> list[Light]:
    """Levels of detail: falling shares of the vertices, for little more than what the first of them costs. Options are those of
    `simplify`; with `out` each is written with `-lod0`, `-lod1` and so on in its name, and a glTF scene as one file."""
    unknown = [name for name in options if name in _SIZES or name not in _OPTIONS]
    if unknown:
        raise _native.OptionError(f"lods: no such option: {', '.join(unknown)}")
    defaults = {"mesh": mesh, **_OPTIONS}
    return list(_results(mesh, {"lods": list(ratios)}, {**defaults, **options}, n_levels=len(ratios)))


_SIZES = ("ratio", "vertices", "faces", "error", "size")
# Options that say where files are and what becomes of them.
_FILES = ("out", "format", "weights", "picture", "report", "strict", "force")
# Options that say nothing to the simplifier.
_OWN = ("mesh", "attributes", "groups", "importance", "threads", "progress", *_FILES)
# Those of `simplify`, with what they are where nobody says anything.
_OPTIONS: dict[str, Any] = {
    name: value for name, value in (simplify.__kwdefaults__ or {}).items() if name not in _SIZES
}


def _one_size(sizes: Mapping[str, Any]) -> dict[str, Any]:
    said = {name: value for name, value in sizes.items() if value is not None}
    if len(said) != 1:
        listed = ", ".join(_SIZES)
        raise _native.OptionError(f"{' and '.join(said) or 'no size'}: give exactly one of {listed}")
    return said


def _results(mesh: Any, target: Mapping[str, Any], options: Mapping[str, Any], n_levels: int = 1) -> tuple[Light, ...]:
    source = given(mesh, options["attributes"], options["groups"])
    asked = {name: value for name, value in options.items() if name not in _SIZES and name not in _OWN}
    files = {"input": source.path, **{name: options[name] for name in _FILES}}
    if files["out"] is not None and os.fspath(files["out"]) == "-":
        raise _native.OptionError("out='-': give the name of a file")
    if isinstance(asked["ignore"], str):
        asked["ignore"] = asked["ignore"].split(",")
    factors = options["importance"]
    if isinstance(factors, str):
        asked["importance"] = factors
        factors = None
    if factors is not None:
        factors = _factors(factors, source)
    said = as_json({**target, **asked}), as_json(files)
    outcome = _native.simplify(*said, source.arrays, factors, options["threads"], options["progress"])
    report = json.loads(outcome.report)
    lights = tuple(_light(kept, outcome, _report_of(report, level), source) for level, kept in enumerate(outcome.results))
    if outcome.unmet is not None:
        raise NotReachedError(outcome.unmet, lights)
    return lights


def _factors(factors: ArrayLike, source: Given) -> NDArray[np.float32]:
    if source.arrays is None:
        raise _native.OptionError("importance: for a file give the name of an attribute, or of a part and its factor")
    values = np.ascontiguousarray(factors, dtype=np.float32).reshape(-1)
    if len(values) != len(source.arrays[0]):
        raise _native.OptionError(f"importance: {len(values)} numbers for {len(source.arrays[0])} vertices: give one for each")
    return values


def _report_of(report: dict[str, Any], level: int) -> dict[str, Any]:
    """The report of a level of detail: that of the run, with what is its own."""
    if not report.get("levels"):
        return report
    own = dict(report["levels"][level])
    outcome, distance = own.pop("outcome"), own.pop("distance")
    shared = {name: value for name, value in report.items() if name != "levels"}
    return {**shared, "output": own, "outcome": outcome, "distance": distance}


def _light(kept: _native.Kept, outcome: _native.Outcome, report: dict[str, Any], source: Given) -> Light:
    attributes = source.named(kept.channels)
    vertices, faces = source.alike(kept.vertices), source.alike(kept.faces)
    light = Light(
        vertices=vertices,
        faces=faces,
        attributes=attributes,
        wedges=kept.wedges,
        groups=source.groups_of(kept.groups),
        group_names={group: name for name, group in outcome.group_names},
        report=report,
        map=_map(kept, outcome, source),
        sources=_of_file(kept.sources, outcome),
        paths=tuple(outcome.paths),
        mesh=None,
    )
    object.__setattr__(light, "mesh", source.back(light))
    return light


def _of_file(sources: NDArray[np.int32] | None, outcome: _native.Outcome) -> NDArray[np.int32] | None:
    if sources is None or outcome.file_vertices is None:
        return sources
    return outcome.file_vertices[sources]


def _map(kept: _native.Kept, outcome: _native.Outcome, source: Given) -> Map | None:
    """The map over the vertices as given: those that were welded went where the one went that stands for them."""
    if kept.map is None:
        return None
    outputs, inputs, corner_faces, corner_weights = kept.map
    file_vertices = outcome.file_vertices
    if file_vertices is None:
        return Map(outputs, inputs, corner_faces, corner_weights)
    n_given = len(source.arrays[0]) if source.arrays is not None else int(file_vertices.max(initial=-1)) + 1
    of_given = np.full(n_given, -1, np.int32)
    of_given[file_vertices] = outputs
    nearest = np.where(inputs >= 0, file_vertices[inputs], -1).astype(np.int32)
    return Map(source.welded(of_given), nearest, corner_faces, corner_weights)

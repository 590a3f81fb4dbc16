"""`simplify`, `simplify_many` and `lods`: what people give, to options and arrays; what comes back, to the type that was given."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._faces import carried
from ._meshes import Given, given
from ._options import DEFAULTS, FILES, OWN, SIZES, Options, Shared, as_it_is, as_said, n_threads
from ._report import Report
from ._result import Light, Map, NeuralMeshWarning, NotReachedError

if TYPE_CHECKING:
    from typing_extensions import Unpack

Arrays: TypeAlias = tuple[NDArray[Any], NDArray[np.int32]]
File: TypeAlias = Union[str, "os.PathLike[str]", bytes, bytearray, memoryview]

M = TypeVar("M")


@overload
def simplify(mesh: File, **options: Unpack[Options]) -> Light[Arrays]: ...
@overload
def simplify(mesh: tuple[ArrayLike, ArrayLike], **options: Unpack[Options]) -> Light[Arrays]: ...
@overload
def simplify(mesh: Light[Any], **options: Unpack[Options]) -> Light[Arrays]: ...
@overload
def simplify(mesh: ArrayLike, triangles: ArrayLike, **options: Unpack[Options]) -> Light[Arrays]: ...
@overload
def simplify(mesh: M, **options: Unpack[Options]) -> Light[M]: ...
def simplify(mesh: Any, triangles: Any = None, **options: Any) -> Light[Any]:
    """Makes a mesh lighter.

    `mesh` is the name of a file, its bytes, or what `open` gives; vertices (n x 3) and triangles (m x 3), as two arguments or a pair; a
    mesh of trimesh, Open3D or pyvista; a `trimesh.Scene`; or a result. `Light.mesh` is of the same type.

    What stays, exactly one of these:

    - `ratio`: share of the vertices: 0.1 or "10%"
    - `vertices`, `faces`: a number of them: 5000, "5k", or "10%" of the input's
    - `error`: the largest distance from the original, proved both ways, in the unit of the mesh: 0.5; or in percent of the diagonal of
      its box: "0.5%". The fewest faces within it are found.
    - `size`: bytes of the file, as 500_000 or "500kB", in the format of `out`, else as PLY

    What the mesh carries:

    - `attributes`: values by name, n x k of vertices or m x 3 x k of corners. `uv`, `normals`, `tangents` and `colors` are known by name
    - `groups`: what of the faces stays apart, borders held: "auto" (materials and named groups), the name of an array of faces, an array of
      m numbers, or `None`. Other values of faces come along (`Light.face_attributes`) and hold nothing
    - `ignore`: what need not stay, of "uv", "normals", "colors", "materials"
    - `importance`: how much each vertex counts, n numbers of at least 0. Of a file the name of an attribute, or "NAME=FACTOR"
    - `textures`: pictures of a file get at most so many pixels a side
    - `compress`: "quantize": numbers of a glTF take fewer bits
    - `bake`: pixels a side of new textures, in a wheel that was built with the feature `bake`

    What has to stay:

    - `lock_boundaries`: boundaries stay as they are
    - `subset`: vertices are some of the given ones, to the last bit
    - `keep`: names of a file whose faces come back as they are
    - `ratio_of`: shares of the vertices by name, beside a size of the whole
    - `keep_features`, `crease_angle` (degrees): edges where the surface bends by more stay edges
    - `seam_error`: how far texture coordinates may move, in texels of 1024
    - `keep_components`, `prune`: no component goes; or those smaller than `prune` go, in the unit of the mesh or "5%" of the diagonal
    - `hidden`: what no view from outside shows: "keep", "cheap" (counts little) or "drop"
    - `symmetric`: `True`, or a plane as "x=0": the result is mirrored
    - `for_`: "shape", "poses" (a mesh that will bend) or "spectrum"

    What is done before: `weld` (`True`: equal positions become one vertex; or up to a distance, in the unit of the mesh or "0.01%"; or
    `False`), `fill_holes` (`True`, or holes of at most so many edges), `printable` (a solid; `True`, or the size of a voxel).

    How: `effort` ("fast", "standard", "best"), `optimize` ("balanced", "mean", "max", "normals"), `scores` ("geometry", "network",
    "bending"), `assembly` ("closed", or "paper" with `close`), `weights` (a file of a network), `seed`, `threads` (one per core where
    nothing is said), `progress` (called with 0 to 1 and the name of the stage).

    What comes back: `map` (where vertices and corners come from), `check` (distances in `report`), `strict` (an error where the size is
    not reached), `on_dirty` (input that had to be cleaned and components that went: "warn", "raise" or "ignore").

    Files: `out`, `format`, `force`, `report`, `picture`, `allow_outside` (files that a mesh names may lie outside its folder).

    Raises `NeuralMeshError` where there is no result, of these `OptionError` for an option, and `NotReachedError` where the result is not
    as asked. Warns (`NeuralMeshWarning`) of a result that is larger than asked.
    """
    asked = _known("simplify", options, SIZES)
    return _results(mesh, triangles, _one_size(options), asked)[0]


def simplify_many(meshes: Iterable[M], **options: Unpack[Options]) -> list[Light[M]]:
    """Results of many meshes, in their order, with the options of `simplify`: so many at a time as there are `threads` (one per core where
    nothing is said), one thread each. The first that fails ends it."""
    n_workers = n_threads(options.get("threads")) or _n_cores()
    options["threads"] = 1
    each: Callable[[M], Light[M]] = lambda mesh: simplify(mesh, **options)
    with ThreadPoolExecutor(n_workers) as pool:
        running = [pool.submit(each, mesh) for mesh in meshes]
        try:
            return [future.result() for future in running]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@overload
def lods(mesh: File, ratios: Sequence[float | str], **options: Unpack[Shared]) -> list[Light[Arrays]]: ...
@overload
def lods(mesh: tuple[ArrayLike, ArrayLike], ratios: Sequence[float | str], **options: Unpack[Shared]) -> list[Light[Arrays]]: ...
@overload
def lods(mesh: Light[Any], ratios: Sequence[float | str], **options: Unpack[Shared]) -> list[Light[Arrays]]: ...
@overload
def lods(mesh: M, ratios: Sequence[float | str], **options: Unpack[Shared]) -> list[Light[M]]: ...
def lods(mesh: Any, ratios: Sequence[float | str], **options: Any) -> list[Light[Any]]:
    """Levels of detail: falling shares of the vertices, for little more than what the first of them costs. Options are those of
    `simplify`; with `out` each is written with `-lod0`, `-lod1` and so on in its name, and a glTF scene as one file."""
    if isinstance(ratios, str) or not isinstance(ratios, Iterable):
        raise _native.OptionError(f"lods: ratios={ratios!r}: give a list of falling shares, such as [0.5, 0.25]")
    return list(_results(mesh, None, {"lods": list(ratios)}, _known("lods", options, ())))


def written(light: Light[Any], files: Mapping[str, Any]) -> bytes | None:
    """The mesh of a result as it is, written to a file or as bytes."""
    source = given(light, None, None, "auto")
    return _native.simplify(as_it_is(), as_said(files), source.arrays, None, None, 1, None).bytes


def _known(name: str, options: Mapping[str, Any], sizes: Sequence[str]) -> dict[str, Any]:
    """The options without the sizes, and what others are where nobody says anything."""
    unknown = [option for option in options if option not in Shared.__annotations__ and option not in sizes]
    if unknown:
        raise _native.OptionError(f"{name}: no such option: {', '.join(unknown)}")
    said = {option: value for option, value in options.items() if option not in sizes}
    return {**dict.fromkeys(Shared.__annotations__), **DEFAULTS, **said}


def _one_size(sizes: Mapping[str, Any]) -> dict[str, Any]:
    said = {name: value for name, value in sizes.items() if name in SIZES and value is not None}
    if len(said) != 1:
        listed = ", ".join(SIZES)
        raise _native.OptionError(f"{' and '.join(said) or 'no size'}: give exactly one of {listed}")
    return said


def _n_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _results(mesh: Any, triangles: Any, target: Mapping[str, Any], options: dict[str, Any]) -> tuple[Light[Any], ...]:
    if options["on_dirty"] not in ("warn", "raise", "ignore"):
        raise _native.OptionError(f"on_dirty={options['on_dirty']!r}: choose from warn, raise, ignore")
    source = given(mesh if triangles is None else (mesh, triangles), options["attributes"], options["groups"], options["on_dirty"])
    asked = {name: value for name, value in options.items() if name not in OWN}
    if source.ignores_groups:
        asked["ignore"] = [*(asked["ignore"] or ()), "materials"]
    files = {"input": source.path, **{name: options[name] for name in FILES}}
    if files["out"] is not None and os.fspath(files["out"]) == "-":
        raise _native.OptionError("out='-': give the name of a file")
    if source.is_scene and files["out"] is None:
        files.update(bytes=True, format="glb")
    if isinstance(asked["ignore"], str):
        asked["ignore"] = asked["ignore"].split(",")
    factors = options["importance"]
    if isinstance(factors, str):
        asked["importance"] = factors
        factors = None
    if factors is not None:
        factors = _factors(factors, source)
    wants_map = bool(asked["map"])
    asked["map"] = wants_map or (bool(source.of_faces) and "lods" not in target)
    said = as_said({**target, **asked}), as_said(files)
    threads = n_threads(options["threads"])
    if options["on_dirty"] == "raise" and source.arrays is None:
        _check_file(source, threads)
    outcome = _native.simplify(*said, source.arrays, source.file, factors, threads, options["progress"])
    report = outcome.report
    results = zip(outcome.results, _of_scene(outcome))
    lights = tuple(_light(kept, outcome, _report_of(report, level), source, wants_map) for level, kept in enumerate(results))
    if outcome.unmet is not None:
        raise NotReachedError(outcome.unmet, lights)
    _tell(lights, source, options)
    return lights


def _check_file(source: Given, threads: int | None) -> None:
    """Refuses a file of which faces would be left out, before anything is written."""
    report = _native.simplify(as_it_is(), as_said({"input": source.path}), None, source.file, None, threads, None).report
    source.refuse(report["cleaned"])


def _factors(factors: ArrayLike, source: Given) -> NDArray[np.float32]:
    if source.arrays is None:
        raise _native.OptionError("importance: for a file give the name of an attribute, or NAME=FACTOR")
    values = np.ascontiguousarray(factors, dtype=np.float32).reshape(-1)
    if len(values) != len(source.arrays[0]):
        raise _native.OptionError(f"importance: {len(values)} numbers for {len(source.arrays[0])} vertices: give one for each")
    return values


def _of_scene(outcome: _native.Outcome) -> Sequence[_native.ResultArrays | None]:
    """The meshes of the scenes that were written, each as one: those of a scene lie side by side until then."""
    n_levels = len(outcome.results)
    if outcome.file_vertices is not None:
        return [None] * n_levels
    if outcome.bytes is not None:
        return [_native.simplify(as_it_is(), {}, None, (outcome.bytes, "scene.glb"), None, 1, None).results[0]]
    paths = outcome.paths if len(outcome.paths) == n_levels else outcome.paths[:1] if n_levels == 1 else []
    read = [_native.simplify(as_it_is(), as_said({"input": path}), None, None, None, 1, None).results[0] for path in paths]
    return read or [None] * n_levels


def _report_of(report: dict[str, Any], level: int) -> Report:
    """The report of a level of detail: that of the run, with what is its own."""
    if not report.get("levels"):
        return report  # type: ignore[return-value]
    own = dict(report["levels"][level])
    told = {name: own.pop(name) for name in ("outcome", "distance", "screen_coverage", "certified") if name in own}
    shared = {name: value for name, value in report.items() if name != "levels"}
    return {**shared, "output": own, **told}  # type: ignore[typeddict-item]


def _light(
    both: tuple[_native.ResultArrays, _native.ResultArrays | None], outcome: _native.Outcome, report: Report, source: Given, wants_map: bool
) -> Light[Any]:
    own, placed = both
    kept = placed or own
    vertices, faces = source.alike(kept.vertices), source.alike(kept.faces)
    way = _map(own, outcome, source)
    of_faces, lost = carried(source, report, way)
    if lost:
        report = {**report, "notes": [*report.get("notes", []), lost]}
    light: Light[Any] = Light(
        vertices=vertices,
        faces=faces,
        attributes=source.named(kept.channels),
        wedges=kept.wedges,
        groups=source.groups_of(kept.groups),
        group_names={group: name for name, group in outcome.group_names},
        face_attributes=of_faces,
        report=report,
        map=way if wants_map else None,
        sources=_of_file(own.sources, outcome),
        paths=tuple(outcome.paths),
        mesh=None,
    )
    object.__setattr__(light, "mesh", source.back(light) if source.scene is None else source.scene(outcome.bytes, light))
    return light


def _of_file(sources: NDArray[np.int32] | None, outcome: _native.Outcome) -> NDArray[np.int32] | None:
    if sources is None or outcome.file_vertices is None:
        return sources
    return outcome.file_vertices[sources]


def _map(kept: _native.ResultArrays, outcome: _native.Outcome, source: Given) -> Map | None:
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


def _tell(lights: Sequence[Light[Any]], source: Given, options: Mapping[str, Any]) -> None:
    """Warns of what is not as one might think."""
    first = lights[0]
    pruned = first.report["output"]["components_pruned"]
    dirt = source.dirt_of(first.cleaned)
    if pruned and not options["prune"] and options["hidden"] != "drop":
        dirt.append(f"{pruned} components were dropped: keep_components=True keeps all")
    if dirt and options["on_dirty"] == "raise":
        raise _native.NeuralMeshError("; ".join(dirt))
    words = dirt if options["on_dirty"] == "warn" else []
    words += [light.outcome for light in lights if not light.reached][:1]
    words += [note for note in first.report.get("notes", ()) if note.startswith("lost: ")]
    for word in words:
        # The line that called `simplify` or `lods`.
        warnings.warn(word, NeuralMeshWarning, stacklevel=4)

"""Simplifies meshes: converts the input and options for the compiled module, and results back to the type of the input."""

from __future__ import annotations

import difflib
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._faces import carry_face_values
from ._meshes import MeshInput, array_of, pack, read_input
from ._options import FILES, OWN, SIZES, Number, Options, OptionsWithoutRatio, UNASKED, Shared, identity_options, to_native, n_threads
from ._plain import is_plain, is_plain_mesh, only_rising, simplify_plain
from ._report import Report
from ._result import Light, Map, Mesh, NeuralMeshWarning, NotReachedError, Rows

if TYPE_CHECKING:
    from typing_extensions import Unpack

M = TypeVar("M", bound=Mesh)


@overload
def simplify(mesh: M, triangles: Rows | None = None, *, ratio: Number | str, **options: Unpack[Shared]) -> Light[M]: ...
@overload
def simplify(mesh: M, triangles: Rows | None = None, **options: Unpack[OptionsWithoutRatio]) -> Light[M]: ...
def simplify(mesh: Any, triangles: Any = None, **options: Any) -> Light[Any]:
    """Simplifies a mesh to a given size.

    `mesh` is one of: the path of a file, its bytes, or an open file; vertices (n x 3) and triangles (m x 3), as two arguments or a pair;
    a mesh of trimesh, Open3D, pyvista, meshio or PyMeshLab; a `trimesh.Scene`; a result. `Light.mesh` has the type of the input.

    Clean vertices and faces alone, with a number or share of them, go to the kernel of the collapse; other calls take the nearer way of files.

    Size of the result, exactly one of these:

    - `ratio`: share of the vertices: 0.1 or "10%"
    - `vertices`, `faces`: number of vertices or faces: 5000, "5k", or "10%" of the input's
    - `error`: fewest faces within a distance to the original, proved both ways, in the unit of the mesh: 0.5; or in percent of the
      diagonal of its bounding box: "0.5%"
    - `size`: bytes of the file, as 500_000 or "500kB", in the format of `out`, else as PLY

    Data of the mesh:

    - `attributes`: values by name, n x k for vertices or m x 3 x k for corners; `uv`, `normals`, `tangents` and `colors` have a meaning;
      `morph_0`, `morph_1` and so on are offsets of the vertices (n x 3) in poses, which `for_="poses"` counts
    - `groups`: groups of faces whose borders stay: "auto" (materials and named groups), the name of a face array, an array of m numbers,
      or `None`. Other face values are carried to `Light.face_attributes`, and their borders may move
    - `ignore`: data that may be lost, of "uv", "normals", "colors", "materials"
    - `importance`: weight of each vertex, n numbers of at least 0; for a file, the name of an attribute, or "NAME=FACTOR"
    - `textures`: largest number of pixels per side of a file's images
    - `compress`: "quantize" stores the numbers of a glTF in fewer bits
    - `bake`: pixels per side of new textures; needs a wheel built with the feature `bake`

    Constraints:

    - `lock_boundaries`: keeps boundaries unchanged
    - `subset`: keeps vertices of the input, at their exact positions
    - `keep`: names in a file whose faces stay unchanged
    - `ratio_of`: shares of the vertices by name, in addition to the size of the whole
    - `keep_features`, `crease_angle`: keeps edges where the surface bends by more than an angle in degrees
    - `seam_error`: largest shift of texture coordinates, in texels of a texture with 1024 a side
    - `keep_components`: keeps all components
    - `prune`: drops components smaller than this, in the unit of the mesh or "5%" of the diagonal
    - `hold_shape`: largest deformation of a component, such as "1%", that no size may exceed; True for 1 %
    - `hidden`: treatment of surfaces that are invisible from outside: "keep" or "drop"
    - `for_`: purpose: "shape" or "poses" (a mesh that will bend)

    Repair before the simplification:

    - `weld`: merges vertices at equal positions (`True`, the default), or within a distance, in the unit of the mesh or "0.01%"
    - `fill_holes`: fills all holes (`True`), or those of at most this many edges
    - `printable`: makes one closed solid; `True`, or the size of a voxel

    Method:

    - `effort`: time against quality: "fast", "standard" or "best"; without it, clean arrays take the way of "fast" and move nearer once
    - `optimize`: figure to favor: "balanced", "mean", "max", "normals" or "looks"
    - `scores`: source of vertex scores: "geometry", "network" or "bending"
    - `assembly`: "closed", or "paper", the latter with `close`
    - `weights`: file of a network
    - `seed`: seed of all random choices, 0 by default
    - `threads`: one per core by default
    - `progress`: called with a share from 0 to 1 and the name of the stage; an exception it raises stops the run

    Results:

    - `map`: fills `Light.map`
    - `check`: measures distances for `Light.report`
    - `strict`: raises an error if the size is not reached
    - `on_dirty`: reaction to cleaned input and dropped components: "warn" (the default), "raise" or "ignore"

    Files: `out`, `format`, `force` (replaces existing files), `report`, `picture`, `allow_outside` (allows files outside the mesh's folder).

    Raises `OptionError` for a wrong option, `NotReachedError` for a missed bound, and `NeuralMeshError` if there is no result. Warns with
    `NeuralMeshWarning` of a result larger than requested.
    """
    selected = _fill_defaults("simplify", options, SIZES)
    return _simplify_levels(mesh, triangles, _check_size(options), selected)[0]


def simplify_many(meshes: Iterable[M], **options: Unpack[Options]) -> list[Light[M]]:
    """Simplifies many meshes in parallel, one thread each, and returns the results in order; all are read first.

    Options are those of `simplify`; `threads` is the number of meshes at a time, one per core by default. The first exception ends all."""
    selected, size = _fill_defaults("simplify_many", options, SIZES), _check_size(options)
    sources = [read_input(mesh, selected["attributes"], selected["groups"], selected["on_dirty"]) for mesh in meshes]
    plain = [i for i, source in enumerate(sources) if is_plain_mesh(source)] if is_plain(selected, size) else []
    lights = dict(zip(plain, simplify_plain([sources[i] for i in plain], size, selected)))
    alone = {**selected, "threads": 1}
    simplify_one: Callable[[int], Light[M]] = lambda i: lights.get(i) or _simplify_wholly(sources[i], size, alone)[0]
    if len(lights) == len(sources) and all(lights.values()):
        return [simplify_one(i) for i in range(len(sources))]
    with ThreadPoolExecutor(n_threads(selected["threads"]) or _n_cores()) as pool:
        running = [pool.submit(simplify_one, i) for i in range(len(sources))]
        try:
            return [future.result() for future in running]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def lods(mesh: M, ratios: Sequence[float | str], **options: Unpack[Shared]) -> list[Light[M]]:
    """Makes levels of detail in one pass: one result for each of `ratios`, falling shares of the vertices.

    Options are those of `simplify`. With `out`, files get `-lod0`, `-lod1` and so on in their names; a glTF scene is one file. `engine`
    names levels and files as "unity", "unreal", "godot" or "gltf" do. Raises `OptionError` if `ratios` is not a list."""
    if isinstance(ratios, str) or not isinstance(ratios, Iterable):
        raise _native.OptionError(f"lods: ratios={ratios!r}: give a list of falling shares, such as [0.5, 0.25]")
    return list(_simplify_levels(mesh, None, {"lods": list(ratios)}, _fill_defaults("lods", options, ())))


def write_light(light: Light[Any], files: Mapping[str, Any]) -> bytes | None:
    """Writes the mesh of a result unchanged; returns the bytes if no file is named, else `None`."""
    source = read_input(light, None, None, "auto")
    return _native.simplify(identity_options(), to_native(files), source.arrays, None, None, 1, None).bytes


def _fill_defaults(name: str, options: Mapping[str, Any], sizes: Sequence[str]) -> dict[str, Any]:
    """Returns the options without sizes, completed by the defaults; rejects unknown names."""
    known = [*sizes, *Shared.__annotations__]
    for option in options:
        if option not in known:
            nearest = difflib.get_close_matches(option, known, 1)
            advice = f"; did you mean {nearest[0]}?" if nearest else f": choose from {', '.join(known)}"
            raise _native.OptionError(f"{name}: no such option: {option[:80]}{advice}")
    on_dirty = options.get("on_dirty", "warn")
    if on_dirty not in ("warn", "raise", "ignore"):
        raise _native.OptionError(f"on_dirty={on_dirty!r}: choose from warn, raise, ignore")
    others = {option: value for option, value in options.items() if option not in sizes}
    return {**UNASKED, **others}


def _check_size(sizes: Mapping[str, Any]) -> dict[str, Any]:
    given = {name: value for name, value in sizes.items() if name in SIZES and value is not None}
    if len(given) != 1:
        listed = ", ".join(SIZES)
        raise _native.OptionError(f"{' and '.join(given) or 'no size'}: give exactly one of {listed}")
    return given


def _n_cores() -> int:
    """Returns the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _simplify_levels(mesh: Any, triangles: Any, target: Mapping[str, Any], options: dict[str, Any]) -> tuple[Light[Any], ...]:
    # The input with its attributes, and the options of the simplifier apart from those about files.
    source = read_input(mesh if triangles is None else (mesh, triangles), options["attributes"], options["groups"], options["on_dirty"])
    if is_plain(options, target) and is_plain_mesh(source):
        if options["progress"] is not None:
            options = {**options, "progress": only_rising(options["progress"])}
        plain = simplify_plain([source], target, options)[0]
        if plain is not None:
            return (plain,)
    return _simplify_wholly(source, target, options)


def _simplify_wholly(source: MeshInput, target: Mapping[str, Any], options: dict[str, Any]) -> tuple[Light[Any], ...]:
    selected, factors = _prepare_options(options, source)
    files = {"input": source.path, **{name: options[name] for name in FILES}}
    if files["out"] is not None and os.fspath(files["out"]) == "-":
        raise _native.OptionError("out='-': give the name of a file")
    if source.is_scene and files["out"] is None:
        files.update(bytes=True, format="glb")
    # Face values are carried by the map, so it is needed for them, too.
    wants_map = bool(selected["map"])
    selected["map"] = wants_map or (bool(source.face_values) and "lods" not in target)
    native_options = to_native({**target, **selected}), to_native(files)
    threads = n_threads(options["threads"])
    if options["on_dirty"] == "raise" and source.arrays is None:
        _check_file(source, threads)
    outcome = _native.simplify(*native_options, source.arrays, source.file, factors, threads, options["progress"])
    report = outcome.report
    results = zip(outcome.results, _read_scene_results(outcome))
    lights = tuple(_make_light(kept, outcome, _level_report(report, level), source, wants_map) for level, kept in enumerate(results))
    if outcome.unmet is not None:
        raise NotReachedError(outcome.unmet, lights)
    _warn_of_surprises(lights, source, options)
    return lights


def _prepare_options(options: Mapping[str, Any], source: MeshInput) -> tuple[dict[str, Any], NDArray[np.float32] | None]:
    """Returns the simplifier's options, and the importance of each vertex if it is given in numbers."""
    selected = {name: value for name, value in options.items() if name not in OWN}
    if source.ignores_groups:
        selected["ignore"] = [*(selected["ignore"] or ()), "materials"]
    if isinstance(selected["ignore"], str):
        selected["ignore"] = selected["ignore"].split(",")
    factors = options["importance"]
    if isinstance(factors, str):
        selected["importance"] = factors
        factors = None
    return selected, None if factors is None else _read_importance(factors, source)


def _check_file(source: MeshInput, threads: int | None) -> None:
    """Raises `NeuralMeshError` for a file with invalid faces, before anything is written."""
    report = _native.simplify(identity_options(), to_native({"input": source.path}), None, source.file, None, threads, None).report
    source.raise_if_dirty(report["cleaned"])


def _read_importance(factors: ArrayLike, source: MeshInput) -> NDArray[np.float32]:
    if source.arrays is None:
        raise _native.OptionError("importance: for a file give the name of an attribute, or NAME=FACTOR")
    values = pack(array_of(factors), np.float32).reshape(-1)
    if len(values) != len(source.arrays[0]):
        raise _native.OptionError(f"importance: {len(values)} numbers for {len(source.arrays[0])} vertices: give one for each")
    return values


def _read_scene_results(outcome: _native.Outcome) -> Sequence[_native.ResultArrays | None]:
    """Reads the written scenes, each as one mesh in its final placement; `None` for results that are no scenes."""
    n_levels = len(outcome.results)
    if outcome.file_vertices is not None:
        return [None] * n_levels
    if outcome.bytes is not None:
        return [_native.simplify(identity_options(), {}, None, (outcome.bytes, "scene.glb"), None, 1, None).results[0]]
    paths = outcome.paths if len(outcome.paths) == n_levels else outcome.paths[:1] if n_levels == 1 else []
    read = [_native.simplify(identity_options(), to_native({"input": path}), None, None, None, 1, None).results[0] for path in paths]
    return read or [None] * n_levels


def _level_report(report: dict[str, Any], level: int) -> Report:
    """Returns the report of one level of detail: the run's report with the level's own fields."""
    if not report.get("levels"):
        return report  # type: ignore[return-value]
    own = dict(report["levels"][level])
    level_fields = {name: own.pop(name) for name in ("outcome", "distance", "screen_coverage", "switch_distance", "certified") if name in own}
    shared = {name: value for name, value in report.items() if name != "levels"}
    return {**shared, "output": own, **level_fields}  # type: ignore[typeddict-item]


def _make_light(
    both: tuple[_native.ResultArrays, _native.ResultArrays | None], outcome: _native.Outcome, report: Report, source: MeshInput, wants_map: bool
) -> Light[Any]:
    own, placed = both
    kept = placed or own
    vertices, faces = source.convert_like(kept.vertices), source.convert_like(kept.faces)
    corner_map = _make_map(own, outcome, source)
    face_values, lost = carry_face_values(source, report, corner_map)
    if lost:
        report = {**report, "notes": [*report.get("notes", []), lost]}
    light: Light[Any] = Light(
        vertices=vertices,
        faces=faces,
        attributes=source.name_channels(kept.channels),
        wedges=kept.wedges,
        groups=source.restore_groups(kept.groups),
        group_names={group: name for name, group in outcome.group_names},
        face_attributes=face_values,
        report=report,
        map=corner_map if wants_map else None,
        sources=_file_sources(own.sources, outcome),
        paths=tuple(outcome.paths),
        _mesh=None,
    )
    object.__setattr__(light, "_mesh", source.back(light) if source.scene is None else source.scene(outcome.bytes, light))
    return light


def _file_sources(sources: NDArray[np.int32] | None, outcome: _native.Outcome) -> NDArray[np.int32] | None:
    if sources is None or outcome.file_vertices is None:
        return sources
    return outcome.file_vertices[sources]


def _make_map(kept: _native.ResultArrays, outcome: _native.Outcome, source: MeshInput) -> Map | None:
    """Makes the map over the input's vertices before welding; welded vertices share a result vertex."""
    if kept.map is None:
        return None
    outputs, inputs, corner_faces, corner_weights = kept.map
    file_vertices = outcome.file_vertices
    if file_vertices is None:
        return Map(outputs, inputs, corner_faces, corner_weights)
    n_given = len(source.arrays[0]) if source.arrays is not None else int(file_vertices.max(initial=-1)) + 1
    outputs_of_input = np.full(n_given, -1, np.int32)
    outputs_of_input[file_vertices] = outputs
    nearest = np.where(inputs >= 0, file_vertices[inputs], -1).astype(np.int32)
    return Map(source.spread_to_welded(outputs_of_input), nearest, corner_faces, corner_weights)


def _warn_of_surprises(lights: Sequence[Light[Any]], source: MeshInput, options: Mapping[str, Any]) -> None:
    """Warns of cleaned input, dropped components, missed sizes and lost data, as `on_dirty` says."""
    first = lights[0]
    pruned = first.report["output"]["components_pruned"]
    dirt = source.describe_dirt(first.cleaned)
    if pruned and not options["prune"] and options["hidden"] != "drop":
        dirt.append(f"{pruned} components were dropped: keep_components=True keeps all")
    if dirt and options["on_dirty"] == "raise":
        raise _native.NeuralMeshError("; ".join(dirt))
    lines = dirt if options["on_dirty"] == "warn" else []
    lines += [light.outcome for light in lights if not light.reached][:1]
    lines += [note for note in first.report.get("notes", ()) if note.startswith("lost: ")]
    for line in lines:
        # The level of the line that called `simplify` or `lods`.
        warnings.warn(line, NeuralMeshWarning, stacklevel=5)

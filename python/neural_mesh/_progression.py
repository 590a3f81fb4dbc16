"""Progressions: one collapse, from which meshes of any size are made."""

from __future__ import annotations

import os
from typing import Any, Generic, TypeVar

from . import _native
from ._meshes import MeshInput, read_input
from ._options import FILES, Number, Path, Whole, n_threads, to_native
from ._result import Light
from ._simplify import _fill_defaults, _level_report, _make_light, _prepare_options, _read_scene_results

M = TypeVar("M")


class Progression(Generic[M]):
    """All levels of a mesh, from `progression` or `load_progression`.

    Levels are refined toward the original, as results of `simplify` are; with `refined=False` the vertices stay where the collapse left
    them, which takes milliseconds."""

    def __init__(self, native: _native.Progression, source: MeshInput) -> None:
        self._native = native
        self._source = source

    def __repr__(self) -> str:
        return f"Progression({self.n_vertices} vertices, {self.n_faces} faces)"

    @property
    def n_vertices(self) -> int:
        """Number of vertices of the finest level."""
        return self._native.size[0]

    @property
    def n_faces(self) -> int:
        """Number of faces of the finest level."""
        return self._native.size[1]

    @property
    def proved(self) -> list[tuple[int, float]]:
        """Vertices and proved largest distance of each proved level, in falling size; empty without `prove=True`."""
        return self._native.proved_levels

    def at_faces(self, n: Whole | str, *, refined: bool = True, out: Path | None = None, force: bool = False) -> Light[M]:
        """Makes a mesh of `n` faces: 5000, "5k" or "10%"; writes it to `out` if given, and replaces a file there with `force`."""
        return self._level({"faces": n}, refined, out, force)

    def at_vertices(self, n: Whole | str, *, refined: bool = True, out: Path | None = None, force: bool = False) -> Light[M]:
        """Makes a mesh of `n` vertices, as `at_faces` does."""
        return self._level({"vertices": n}, refined, out, force)

    def at_error(self, error: Number | str, *, out: Path | None = None, force: bool = False) -> Light[M]:
        """Makes the smallest of the proved levels within a distance, in the unit of the mesh, or "0.5%" of the diagonal.

        The level is not refined. If none is within the distance, the result is the mesh itself. Raises `NeuralMeshError` without
        `prove=True`."""
        return self._level({"error": error}, True, out, force)

    def to_bytes(self) -> bytes:
        """Returns the progression as bytes, which `load_progression` and, in a file ending in .nmp, `neural-mesh simplify` read."""
        return self._native.to_bytes()

    def save(self, path: Path, *, force: bool = False) -> str:
        """Writes the progression to a file and returns its path; `force` replaces a file there, but none that it was made from."""
        self._native.save(path, force)
        return os.fspath(path)

    def _level(self, target: dict[str, Any], refined: bool, out: Path | None, force: bool) -> Light[M]:
        options = {**target, "check": False, "effort": "standard" if refined else "fast"}
        files: dict[str, Any] = {"out": out, "force": force}
        if self._source.is_scene and out is None:
            files.update(bytes=True, format="glb")
        outcome = self._native.level(to_native(options), to_native(files), None)
        both = outcome.results[0], _read_scene_results(outcome)[0]
        return _make_light(both, outcome, _level_report(outcome.report, 0), self._source, False)


def progression(mesh: Any, triangles: Any = None, *, prove: bool = False, **options: Any) -> Progression[Any]:
    """Collapses a mesh once, for meshes of any size.

    `mesh` and options are those of `simplify`, without a size and `out`. `prove` also proves distances of levels at halving sizes, for
    `Progression.at_error`; it takes longer."""
    selected = _fill_defaults("progression", options, ())
    if any(selected[name] is not None for name in ("out", "picture", "report")):
        raise _native.OptionError("progression: out, picture and report: give out to at_faces or at_vertices")
    source = read_input(mesh if triangles is None else (mesh, triangles), selected["attributes"], selected["groups"], selected["on_dirty"])
    own, factors = _prepare_options(selected, source)
    files = {"input": source.path, **{name: selected[name] for name in FILES}}
    native = _native.progression(
        to_native({"ratio": 1.0, **own}),
        to_native(files),
        source.arrays,
        source.file,
        factors,
        prove,
        n_threads(selected["threads"]),
        selected["progress"],
    )
    return Progression(native, source)


def load_progression(file: str | os.PathLike[str] | bytes) -> Progression[Any]:
    """Loads a progression from a file or its bytes; levels are pairs of arrays.

    Raises `NeuralMeshError` for anything else."""
    if not isinstance(file, bytes):
        with open(file, "rb") as opened:
            file = opened.read()
    return Progression(_native.read_progression(file), MeshInput())

"""Options by name: what each may be, what it is where nobody says anything, and as the compiled module takes them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike

from ._native import OptionError

Number: TypeAlias = Union[float, "np.floating[Any]", "np.integer[Any]"]
Whole: TypeAlias = Union[int, "np.integer[Any]"]
Path: TypeAlias = Union[str, "os.PathLike[str]"]
Progress: TypeAlias = Callable[[float, str], object]


class Sizes(TypedDict, total=False):
    """What stays: exactly one of them."""

    ratio: Number | str | None
    vertices: Whole | str | None
    faces: Whole | str | None
    error: Number | str | None
    size: Whole | str | None


class Shared(TypedDict, total=False):
    """Options of `simplify` and `lods`."""

    out: Path | None
    attributes: Mapping[str, ArrayLike] | None
    groups: Literal["auto"] | str | ArrayLike | None
    importance: str | ArrayLike | None
    lock_boundaries: bool
    subset: bool
    close: bool
    place: bool
    keep: Sequence[str] | None
    ratio_of: Mapping[str, Number | str] | None
    keep_features: bool
    crease_angle: Number | None
    seam_error: Number | None
    keep_components: bool
    prune: bool | Number | str
    hidden: Literal["keep", "cheap", "drop"] | None
    for_: Literal["shape", "poses", "spectrum"] | None
    fill_holes: bool | Whole
    printable: bool | Number | str
    weld: bool | Number | str
    symmetric: bool | str
    ignore: Sequence[Literal["uv", "normals", "colors", "materials"]] | None
    map: bool
    optimize: Literal["balanced", "mean", "max", "normals"] | None
    effort: Literal["fast", "standard", "best"] | None
    scores: Literal["bending", "network", "geometry"] | None
    assembly: Literal["closed", "paper"] | None
    weights: Path | None
    textures: Whole | None
    compress: bool | str | None
    bake: Whole | None
    seed: Whole
    strict: bool
    check: bool
    on_dirty: Literal["warn", "raise", "ignore"]
    threads: Whole | None
    progress: Progress | None
    format: str | None
    force: bool
    picture: Path | None
    report: Path | None
    allow_outside: bool


class Options(Sizes, Shared, total=False):
    """Options of `simplify`."""


SIZES = tuple(Sizes.__annotations__)
# Options that say where files are and what becomes of them.
FILES = ("out", "format", "weights", "picture", "report", "strict", "force")
# Options that say nothing to the simplifier.
OWN = ("attributes", "groups", "importance", "on_dirty", "threads", "progress", *FILES)
# Those that are something where nobody says anything.
DEFAULTS: dict[str, Any] = {"groups": "auto", "weld": True, "check": False, "on_dirty": "warn", "seed": 0}
# More threads than any machine has.
_MOST_THREADS = 1024
# Options that are negated where they are given by name.
_NEGATED = {"check": "no_check", "weld": "no_weld"}


def n_threads(threads: Any) -> int | None:
    """A number of threads; none where there is one per core."""
    n = plain(threads)
    if n is None or (isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= _MOST_THREADS):
        return n
    raise OptionError(f"threads={threads!r}: give a number from 1 to {_MOST_THREADS}")


def as_said(options: Mapping[str, Any]) -> dict[str, Any]:
    """All options that are given: those that are `None` or `False` are not, but for `check` and `weld`, which are on by default there."""
    said: dict[str, Any] = {}
    for name, value in options.items():
        if value is None or value is False and name not in _NEGATED:
            continue
        value = plain(value)
        if name in _NEGATED and isinstance(value, bool):
            said[_NEGATED[name]] = not value
        elif value is not False:
            # A word of Python itself has a `_` behind it.
            said[name.rstrip("_")] = value
    return said


def as_it_is() -> dict[str, Any]:
    """The options under which a mesh comes back with all that it has."""
    return as_said({"ratio": 1.0, "check": False, "keep_components": True})


def plain(value: Any) -> Any:
    """A value of Python's own kinds."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    # Numbers of numpy and arrays of one are none; one that is not finite is refused by its name.
    if hasattr(value, "item") and getattr(value, "size", 1) == 1:
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, Iterable) else value

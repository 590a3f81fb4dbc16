"""Types and defaults of the options, and their conversion for the compiled module."""

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


# made from the list of options: start
class Sizes(TypedDict, total=False):
    """Sizes of the result, of which exactly one is given."""

    ratio: Number | str | None
    vertices: Whole | str | None
    faces: Whole | str | None
    error: Number | str | None
    size: Whole | str | None


class JobOptions(TypedDict, total=False):
    """Options of the simplifier."""

    engine: Literal["unity", "unreal", "godot", "gltf"] | None
    field_of_view: Number | None
    for_: Literal["shape", "poses"] | None
    keep_features: bool
    crease_angle: Number | None
    lock_boundaries: bool
    keep_components: bool
    keep: Sequence[str] | None
    subset: bool
    ignore: Sequence[Literal["uv", "normals", "colors", "materials"]] | None
    seam_error: Number | None
    prune: bool | Number | str
    hold_shape: bool | Number | str
    hidden: Literal["keep", "drop"] | None
    fill_holes: bool | Whole
    printable: bool | Number | str
    weld: bool | Number | str
    bake: Whole | None
    compress: bool | Literal["meshopt", "quantize"]
    textures: Whole | None
    allow_outside: bool
    optimize: Literal["balanced", "mean", "max", "normals", "looks"] | None
    effort: Literal["fast", "standard", "best"] | None
    scores: Literal["bending", "network", "geometry"] | None
    assembly: Literal["closed", "paper"] | None
    draw: Literal["scattered", "multinomial"] | None
    close: bool
    place: bool
    seed: Whole | None
    check: bool


# made from the list of options: end
class Shared(JobOptions, total=False):
    """Options of `simplify` and `lods`, with those of this package."""

    out: Path | None
    attributes: Mapping[str, ArrayLike] | None
    groups: Literal["auto"] | str | ArrayLike | None
    importance: str | ArrayLike | None
    ratio_of: Mapping[str, Number | str] | None
    map: bool
    weights: Path | None
    strict: bool
    on_dirty: Literal["warn", "raise", "ignore"]
    threads: Whole | None
    progress: Progress | None
    format: str | None
    force: bool
    picture: Path | None
    report: Path | None


class Options(Sizes, Shared, total=False):
    """Options of `simplify`."""


class OptionsWithoutRatio(Shared, total=False):
    """Options of `simplify` without a ratio, so that type checkers find a second size beside one."""

    vertices: Whole | str | None
    faces: Whole | str | None
    error: Number | str | None
    size: Whole | str | None


SIZES = tuple(Sizes.__annotations__)
# Options about files.
FILES = ("out", "format", "weights", "picture", "report", "strict", "force")
# Options that this package handles itself and does not pass to the simplifier.
OWN = ("attributes", "groups", "importance", "on_dirty", "threads", "progress", *FILES)
# Defaults of the options that are on or set unless given.
DEFAULTS: dict[str, Any] = {"groups": "auto", "weld": True, "check": False, "on_dirty": "warn", "seed": 0}
# Upper bound of `threads`, above the number of cores of any common machine.
_MOST_THREADS = 1024
# Options where nothing is asked for.
UNASKED: dict[str, Any] = {**dict.fromkeys(Shared.__annotations__), **DEFAULTS}
# Options that are on by default, with their negated names in the compiled module.
_NEGATED = {"check": "no_check", "weld": "no_weld"}


def n_threads(threads: Any) -> int | None:
    """Returns a checked number of threads; `None` means one per core."""
    n = plain(threads)
    if n is None or (isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= _MOST_THREADS):
        return n
    raise OptionError(f"threads={threads!r}: give a number from 1 to {_MOST_THREADS}")


def to_native(options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options for the compiled module: without `None` and `False`, and with `check` and `weld` negated if `False`."""
    native: dict[str, Any] = {}
    for name, value in options.items():
        if value is None or value is False and name not in _NEGATED:
            continue
        value = plain(value)
        if name in _NEGATED and isinstance(value, bool):
            native[_NEGATED[name]] = not value
        elif value is not False:
            # Names that are Python keywords end in `_` here.
            native[name.rstrip("_")] = value
    return native


def identity_options() -> dict[str, Any]:
    """Returns the options under which a mesh comes back unchanged."""
    return to_native({"ratio": 1.0, "check": False, "keep_components": True})


def plain(value: Any) -> Any:
    """Converts a value to Python's built-in types: numpy scalars to numbers, paths to strings, iterables to lists."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    # The compiled module rejects numbers that are not finite by their text.
    if hasattr(value, "item") and getattr(value, "size", 1) == 1:
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, Iterable) else value

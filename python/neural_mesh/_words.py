"""Options as the words of the program's command line, which the compiled module understands."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

# Options that are there or not.
_FLAGS = ("lock_boundaries", "subset", "close", "keep_features", "keep_components", "strict", "force", "allow_outside", "appearance")


def words(options: Mapping[str, Any]) -> list[str]:
    """Words for all options that are not `None`; the program's names with `_` for `-`."""
    said: list[str] = []
    for name, value in options.items():
        # A word of Python itself has a `_` behind it.
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or (name in _FLAGS and value is False):
            continue
        if name in _FLAGS:
            said.append(option)
        elif name in ("prune", "printable", "fill_holes", "symmetric"):
            # These may stand alone, and take what belongs to them with `=`.
            said += [] if value is False else [option if value is True else f"{option}={_word(value)}"]
        elif name == "weld":
            said += _weld(value)
        elif name == "check":
            said += [] if value else ["--no-check"]
        else:
            # With `=`, so that no value is taken for an option.
            said.append(f"{option}={_word(value)}")
    return said


def _weld(value: bool | float | str) -> list[str]:
    if isinstance(value, bool):
        return [] if value else ["--no-weld"]
    return [f"--weld={_word(value)}"]


def _word(value: Any) -> str:
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, Iterable):
        return ",".join(_word(item) for item in value)
    # A number of numpy prints its type.
    return repr(value.item() if hasattr(value, "item") else value)

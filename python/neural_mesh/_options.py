"""Options as the compiled module takes them: by the program's names with `_` for `-`, as JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

# Options that are negated where they are given by name.
_NEGATED = {"check": "no_check", "weld": "no_weld"}


def as_json(options: Mapping[str, Any]) -> str:
    """All options that are given: those that are `None` or `False` are not, but for `check` and `weld`, which are on by default there."""
    said: dict[str, Any] = {}
    for name, value in options.items():
        if name in _NEGATED and isinstance(value, bool):
            said[_NEGATED[name]] = not value
        elif value is not None and value is not False:
            # A word of Python itself has a `_` behind it.
            said[name.rstrip("_")] = _plain(value)
    return json.dumps(said)


def _plain(value: Any) -> Any:
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    # A number of numpy is none of JSON, nor is one that is not finite, which is refused by its name.
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return [_plain(item) for item in value] if isinstance(value, Iterable) else value

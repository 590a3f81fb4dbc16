"""Promises that are known to be broken, as few and as narrow as can be. A line goes when its promise holds; at last all do."""

from dataclasses import dataclass
from typing import Callable


def extreme(case):
    """Where single precision about one origin cannot hold the mesh."""
    return not case.plain


def extreme_and_locked(case):
    return extreme(case) and "--lock-boundaries" in case.options


def extreme_and_flat(case):
    return extreme(case) and ("offset" in case.recipe or "far apart" in case.recipe)


@dataclass
class Known:
    kind: str
    """The promise, one of `promises.PROMISES`."""
    holds_for: Callable
    """The cases in which it is known to be broken."""
    reason: str


KNOWN = [
    Known("degenerate", extreme_and_locked, "what is locked lies on a line in the numbers of the file"),
    Known("degenerate", extreme_and_flat, "parts have no area in the numbers of the file"),
    Known("read", extreme, "closed sheets thinner than the steps of single precision become one sheet"),
    Known("certified", extreme, "what is certified is the distance from the mesh in single precision"),
    Known("hang", extreme, "merges are tried again and again where parts are too small for the numbers"),
]


def is_known(kind, case):
    return any(known.kind == kind and known.holds_for(case) for known in KNOWN)

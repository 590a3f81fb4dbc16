"""Promises that are known to be broken, each for cases as narrow as possible. Remove a line when its promise holds."""

from dataclasses import dataclass
from typing import Callable


def extreme(case):
    """Returns whether the mesh is far apart, of mixed scales, far from the origin or denormal: `Mesh.plain` is false."""
    return not case.plain


def held(case):
    """Returns whether vertices may not move, or only to others of a flat mesh."""
    return "--lock-boundaries" in case.options or "--subset" in case.options and "flat" in case.recipe


def denormal_solid(case):
    """Returns whether a solid is made of a mesh with denormal coordinates."""
    return extreme(case) and "denormal" in case.recipe and "--printable" in case.options


@dataclass
class Known:
    kind: str
    """The promise, one of `promises.PROMISES`."""
    holds_for: Callable
    """The cases in which it is known to be broken."""
    reason: str


KNOWN = [
    Known("degenerate", held, "what is held lies on a line in the numbers of the file"),
    Known("degenerate", extreme, "parts have no area in the numbers of the file"),
    Known("read", extreme, "closed sheets thinner than the steps of single precision become one sheet"),
    Known("closed again", extreme, "not explained: seen where single precision makes faces one"),
    Known("astray", extreme, "the mesh is as wide as the steps of the numbers of the file"),
    Known("certified", extreme, "what is certified is the distance from the mesh in single precision"),
    Known("error", extreme, "what is bounded is the distance from the mesh in single precision"),
    Known("positions", denormal_solid, "bodies that touch come apart by less than the steps of the numbers"),
    Known("hang", extreme, "merges are tried again and again where parts are too small for the numbers"),
]


def is_known(kind, case):
    return any(known.kind == kind and known.holds_for(case) for known in KNOWN)

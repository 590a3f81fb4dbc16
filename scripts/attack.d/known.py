"""Promises that are known to be broken, as few and as narrow as can be. A line goes when its promise holds; at last all do."""

from dataclasses import dataclass
from typing import Callable


def always(_case):
    return True


def extreme(case):
    """Where single precision about one origin cannot hold the mesh."""
    return not case.plain


def given(option):
    return lambda case: any(word.split("=")[0] == option for word in case.options)


@dataclass
class Known:
    kind: str
    """The promise, one of `promises.PROMISES`."""
    holds_for: Callable
    """The cases in which it is known to be broken."""
    reason: str


KNOWN = [
    Known("closed even", always, "edges with more than two faces are cut open"),
    Known("unchanged", always, "faces go where solids touch, though none was asked to"),
    Known("error", always, "a distance that is not held is called reached, or ends with exit code 0"),
    Known("bytes", always, "a size that is not held ends with exit code 0"),
    Known("degenerate", always, "faces without area are made"),
    Known("read", extreme, "closed sheets thinner than the steps of single precision become one sheet"),
    Known("certified", extreme, "what is certified is the distance from the mesh in single precision"),
    Known("astray", extreme, "vertices fly off where coordinates are denormal or coarse"),
    Known("hang", extreme, "distances take long where large faces lie on each other"),
]


def is_known(kind, case):
    return any(known.kind == kind and known.holds_for(case) for known in KNOWN)

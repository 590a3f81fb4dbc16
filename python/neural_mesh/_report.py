"""The report of a run: what it holds, as types and as a JSON schema."""

from __future__ import annotations

import typing
from typing import Any, TypedDict, Union


class _Shape(TypedDict, total=False):
    closed: bool
    boundary_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    components: int
    euler: int


class Size(_Shape):
    """How large a mesh is; what it is as a surface where a file of the report is written."""

    vertices: int
    faces: int


class Dropped(TypedDict):
    """A component that was dropped: its name, as far as the file has one, and its faces."""

    name: str
    faces: int


class _Written(TypedDict, total=False):
    vertices_written: int
    dropped: list[Dropped]


class Output(Size, _Written):
    """The result, and what became of the input's components, edges and vertices on the way."""

    components_at_minimum: int
    components_keep_shape: bool
    components_pruned: int
    components_hidden: int
    kept_edges: int
    locked_vertices: int
    split_vertices: int
    flipped_edges: int
    separated_vertices: int


class Distance(TypedDict):
    """Distance from the original, both ways, in percent of the diagonal of its box."""

    mean_percent: float
    max_percent: float
    samples: int


class Certified(TypedDict):
    """Bounds of the largest distance, in the unit of the mesh and in percent of the diagonal."""

    lower: float
    upper: float
    lower_percent: float
    upper_percent: float


class Cleaned(TypedDict):
    """Vertices and faces that were cleaned on reading."""

    welded_vertices: int
    unreferenced_vertices: int
    degenerate_faces: int
    duplicate_faces: int
    non_finite_faces: int
    out_of_range_faces: int
    dropped_faces: int


class Repaired(TypedDict):
    """What a repair did before the mesh was simplified."""

    holes_filled: int
    holes_left: int
    faces_added: int
    faces_removed: int
    faces_turned: int
    components_dropped: int
    components_added: int
    components_flipped: int


class NamedShare(TypedDict):
    """What became of a name that had a share of its own."""

    name: str
    ratio: float
    faces_before: int
    faces: int


class _Bake(TypedDict, total=False):
    bake: float


class Seconds(_Bake):
    """Seconds of wall clock, and those of the stages of `simplify` by name."""

    read: float
    simplify: float
    write: float
    check: float
    stages: dict[str, float]


class _Asked(TypedDict, total=False):
    repaired: Repaired
    named: list[NamedShare]
    certified: Certified
    mirror: str
    screen_coverage: Union[float, None]
    notes: list[str]
    free: list[str]


class Report(_Asked):
    """What was done, as `neural-mesh simplify --report` writes it. Fields that nobody asked for are not there."""

    input: Size
    output: Output
    target: dict[str, Any]
    outcome: str
    scores: str
    seed: int
    threads: int
    seconds: Seconds
    cleaned: Cleaned
    distance: Union[Distance, None]


_PLAIN: dict[Any, dict[str, Any]] = {
    int: {"type": "integer"},
    float: {"type": "number"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
    type(None): {"type": "null"},
    Any: {},
}


def report_schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of `Light.report`."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "Report of neural-mesh", **_schema(Report)}


def _schema(kind: Any) -> dict[str, Any]:
    if typing.is_typeddict(kind):
        hints = typing.get_type_hints(kind)
        return {
            "type": "object",
            "properties": {name: _schema(hint) for name, hint in hints.items()},
            "required": sorted(kind.__required_keys__),
            "additionalProperties": False,
        }
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is list:
        return {"type": "array", "items": _schema(inner[0])}
    if origin is dict:
        return {"type": "object", "additionalProperties": _schema(inner[1])}
    if origin is Union:
        return {"anyOf": [_schema(each) for each in inner]}
    return dict(_PLAIN[kind])

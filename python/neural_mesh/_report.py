"""Types and JSON schema of the report of a run."""

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
    """Size of a mesh; a written report also has its topology."""

    vertices: int
    faces: int


class Dropped(TypedDict):
    """A dropped component: its name in the file, or an empty string, and its number of faces."""

    name: str
    faces: int


class _Written(TypedDict, total=False):
    vertices_written: int
    size_with_shape: list[int]
    dropped: list[Dropped]


class Output(Size, _Written):
    """Size of the result, and counts of the components, edges and vertices that were changed or kept."""

    components_at_minimum: int
    components_pruned: int
    components_hidden: int
    kept_edges: int
    locked_vertices: int
    split_vertices: int
    flipped_edges: int
    separated_vertices: int
    shortened_spikes: int


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
    """Numbers of vertices and faces that were removed or merged on reading."""

    welded_vertices: int
    unreferenced_vertices: int
    degenerate_faces: int
    duplicate_faces: int
    non_finite_faces: int
    out_of_range_faces: int
    dropped_faces: int


class Repaired(TypedDict):
    """Counts of the repair that ran before the simplification."""

    holes_filled: int
    holes_left: int
    faces_added: int
    faces_removed: int
    faces_turned: int
    components_dropped: int
    components_added: int
    components_flipped: int


class NamedShare(TypedDict):
    """Faces before and after of a name with its own ratio (`ratio_of`)."""

    name: str
    ratio: float
    faces_before: int
    faces: int


class _Drawn(TypedDict, total=False):
    bake: float
    picture: float


class Seconds(_Drawn):
    """Wall-clock seconds, in total and by stage of `simplify`."""

    read: float
    simplify: float
    write: float
    check: float
    stages: dict[str, float]


class _Optional(TypedDict, total=False):
    repaired: Repaired
    named: list[NamedShare]
    certified: Certified
    screen_coverage: Union[float, None]
    switch_distance: Union[float, None]
    notes: list[str]
    free: list[str]
    estimated_error: float


class Report(_Optional):
    """The report of a run, as `neural-mesh simplify --report` writes it; fields of unused options are absent.

    `estimated_error` is the kernel's estimate of the largest distance, in the unit of the mesh, where arrays alone are simplified."""

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
    """Returns the JSON schema (draft 2020-12) of `Light.report`."""
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

"""`compare`: how results differ from their original, as figures and as a page."""

from __future__ import annotations

import html as text
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypedDict

from . import _native
from ._meshes import Given, given
from ._options import Path, Whole, as_it_is, n_threads

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True)
class Comparison:
    """Figures of results beside their original."""

    results: tuple[Mapping[str, float | None], ...]
    """Figures by name, for each result; `None` for a figure that cannot be measured."""
    units: Mapping[str, str]
    """The unit of each figure."""
    about: Mapping[str, str]
    """The meaning of each figure."""
    page: str | None = field(repr=False)
    """The HTML page that shows the meshes in 3-D without network access, if requested."""

    def __getitem__(self, name: str) -> float | None:
        """A figure of the only result, or of the first."""
        return self.results[0][name]

    def _repr_html_(self) -> str:
        """What a notebook shows: the page, or a table."""
        if self.page is not None:
            return f'<iframe srcdoc="{text.escape(self.page)}" style="width:100%;height:640px;border:0"></iframe>'
        rows = "".join(
            f"<tr><td>{name}</td>{''.join(f'<td>{result[name]}</td>' for result in self.results)}<td>{self.units[name]}</td></tr>"
            for name in self.units
        )
        return f"<table>{rows}</table>"


class Compared(TypedDict, total=False):
    """Options of `compare` and `show`."""

    samples: Whole
    seed: Whole
    appearance: bool
    weld: bool
    html: bool | Path
    force: bool
    threads: Whole | None


def compare(original: Any, *simplified: Any, **options: Unpack[Compared]) -> Comparison:
    """Measures how meshes differ from the one that they were made from: distance, normals, holes, topology, triangles. Meshes are
    what `simplify` takes, and what it gives.

    - `samples`: on each surface; 50,000 where nothing is said. `seed`: of the samples
    - `appearance`: also how alike pictures of them are
    - `weld`: whether equal positions become one vertex first; `True` where nothing is said
    - `html`: also the page: `True` for `Comparison.page`, a name to write it; `force` replaces one that is there
    - `threads`: one per core where nothing is said
    """
    unknown = [name for name in options if name not in Compared.__annotations__]
    if unknown:
        raise _native.OptionError(f"compare: no such option: {', '.join(unknown)}")
    html, weld = options.get("html", False), bool(options.get("weld", True))
    if not simplified:
        raise _native.OptionError("compare: give the original and at least one simplified mesh")
    meshes = [_measured(mesh) for mesh in (original, *simplified)]
    names = ["original", *(f"result {number}" for number in range(1, len(meshes)))]
    figures, page = _native.compare(
        [mesh.path or name for mesh, name in zip(meshes, names)],
        [mesh.arrays for mesh in meshes],
        samples=int(options.get("samples", 50_000)),
        seed=int(options.get("seed", 0)),
        appearance=bool(options.get("appearance", False)),
        weld=weld,
        html=None if html is False else "page.html" if html is True else os.fspath(html),
        writes=not isinstance(html, bool),
        force=bool(options.get("force", False)),
        threads=n_threads(options.get("threads")),
    )
    return _comparison(json.loads(figures), page)


def show(original: Any, *simplified: Any, **options: Unpack[Compared]) -> Comparison:
    """The page of `compare`, with its options: in a notebook it is shown."""
    options.setdefault("html", True)
    return compare(original, *simplified, **options)


def _measured(mesh: Any) -> Given:
    """A mesh to be measured; the bytes of a file as the arrays that it has."""
    source = given(mesh, None, "auto")
    if source.file is None:
        return source
    kept = _native.simplify(as_it_is(), {}, None, source.file, None, None, None).results[0]
    return given((kept.vertices, kept.faces), None, None)


def _comparison(said: Mapping[str, Any], page: str | None) -> Comparison:
    figures = said["figures"]
    return Comparison(
        results=tuple(result["values"] for result in said["results"]),
        units={figure["name"]: figure["unit"] for figure in figures},
        about={figure["name"]: figure["about"] for figure in figures},
        page=page,
    )

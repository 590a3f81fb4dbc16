"""`compare`: how results differ from their original, as figures and as a page."""

from __future__ import annotations

import html as text
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from . import _native
from ._meshes import given


@dataclass(frozen=True)
class Comparison:
    """Figures of results beside their original."""

    results: tuple[Mapping[str, float | None], ...]
    """For each result its figures by name; `None` where one cannot be measured."""
    units: Mapping[str, str]
    """The unit of each figure."""
    about: Mapping[str, str]
    """What each figure is."""
    page: str | None = field(repr=False)
    """A page of HTML that shows the meshes in 3-D and asks for nothing outside itself, where one was asked for."""

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


def compare(
    original: Any,
    *simplified: Any,
    samples: int = 50_000,
    seed: int = 0,
    appearance: bool = False,
    weld: bool = True,
    html: bool | str | os.PathLike[str] = False,
    force: bool = False,
    threads: int | None = None,
) -> Comparison:
    """Measures how meshes differ from the one that they were made from: distance, normals, holes, topology, triangles. Meshes are
    what `simplify` takes, and what it gives. With `html` also the page: `True` for `Comparison.page`, a name to write it."""
    if not simplified:
        raise _native.OptionError("compare: give the original and at least one simplified mesh")
    meshes = [given(mesh, None, None) for mesh in (original, *simplified)]
    names = ["original", *(f"result {number}" for number in range(1, len(meshes)))]
    figures, page = _native.compare(
        [mesh.path or name for mesh, name in zip(meshes, names)],
        [mesh.arrays for mesh in meshes],
        samples=samples,
        seed=seed,
        appearance=appearance,
        weld=weld,
        html=None if html is False else "page.html" if html is True else os.fspath(html),
        writes=not isinstance(html, bool),
        force=force,
        threads=threads,
    )
    return _comparison(json.loads(figures), page)


def show(original: Any, *simplified: Any, **options: Any) -> Comparison:
    """The page of `compare`: in a notebook it is shown."""
    return compare(original, *simplified, **{"html": True, **options})


def _comparison(said: Mapping[str, Any], page: str | None) -> Comparison:
    figures = said["figures"]
    return Comparison(
        results=tuple(result["values"] for result in said["results"]),
        units={figure["name"]: figure["unit"] for figure in figures},
        about={figure["name"]: figure["about"] for figure in figures},
        page=page,
    )

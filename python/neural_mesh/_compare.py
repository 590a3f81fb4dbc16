"""`compare`: how results differ from their original, as figures and as a page."""

from __future__ import annotations

import html as text
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from . import _native
from ._meshes import MeshInput, read_input
from ._options import Path, Whole, identity_options, n_threads

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Names of the figures.
Figure = Literal[
    "vertices", "faces", "chamfer", "distance_mean", "distance_rms", "distance_max", "flip", "ssim", "normals_ssim", "psnr",
    "silhouette_iou", "normal_error", "normal_error_signed", "normal_angle", "turned_faces", "curvature_error", "edges_without_two_faces",
    "open_edges", "boundary_edges", "non_manifold_edges", "flipped_edges", "non_manifold_vertices", "self_intersecting_faces",
    "components_added", "genus_added", "area_change", "volume_change", "smallest_angle", "smallest_angle_mean", "aspect_median",
    "slivers",
]  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """Measured differences between results and their original."""

    results: tuple[Mapping[str, float | None], ...]
    """Figures by name, for each result; `None` for a figure that cannot be measured."""
    units: Mapping[str, str]
    """The unit of each figure."""
    about: Mapping[str, str]
    """The meaning of each figure."""
    page: str | None = field(repr=False)
    """The HTML page that shows the meshes in 3-D without network access, if requested."""

    def __getitem__(self, name: Figure) -> float | None:
        """Returns a figure of the first result, by name."""
        return self.results[0][name]

    def _repr_html_(self) -> str:
        """Returns HTML for a notebook: the page if there is one, else a table of figures."""
        if self.page is not None:
            return f'<iframe srcdoc="{text.escape(self.page)}" style="width:100%;height:640px;border:0"></iframe>'
        rows = "".join(
            f"<tr><td>{name}</td>{''.join(f'<td>{result[name]}</td>' for result in self.results)}<td>{self.units[name]}</td></tr>"
            for name in self.units
        )
        return f"<table>{rows}</table>"


class CompareOptions(TypedDict, total=False):
    """Options of `compare` and `show`."""

    samples: Whole
    seed: Whole
    weld: bool
    html: bool | Path
    force: bool
    threads: Whole | None


def compare(original: Any, *simplified: Any, **options: Unpack[CompareOptions]) -> Comparison:
    """Measures how simplified meshes differ from their original: distance, normals, holes, topology and triangle shape.

    Each mesh is anything that `simplify` takes or returns.

    - `samples`: sample points per surface; 50,000 by default. `seed`: seed of the samples
    - `weld`: merges vertices at equal positions first; `True` by default
    - `html`: also makes a page: `True` fills `Comparison.page`, a path writes the file; `force` replaces an existing one
    - `threads`: one per core by default

    Raises `OptionError` for a wrong option and `NeuralMeshError` for a mesh that cannot be read.
    """
    unknown = [name for name in options if name not in CompareOptions.__annotations__]
    if unknown:
        raise _native.OptionError(f"compare: no such option: {', '.join(unknown)}")
    html, weld = options.get("html", False), bool(options.get("weld", True))
    if not simplified:
        raise _native.OptionError("compare: give the original and at least one simplified mesh")
    meshes = [_load_mesh(mesh) for mesh in (original, *simplified)]
    names = ["original", *(f"result {number}" for number in range(1, len(meshes)))]
    figures, page = _native.compare(
        [mesh.path or name for mesh, name in zip(meshes, names)],
        [mesh.arrays for mesh in meshes],
        samples=int(options.get("samples", 50_000)),
        seed=int(options.get("seed", 0)),
        weld=weld,
        html=None if html is False else "page.html" if html is True else os.fspath(html),
        writes=not isinstance(html, bool),
        force=bool(options.get("force", False)),
        threads=n_threads(options.get("threads")),
    )
    return _comparison(json.loads(figures), page)


def show(original: Any, *simplified: Any, **options: Unpack[CompareOptions]) -> Comparison:
    """Compares as `compare` does and makes the 3-D page, which a notebook displays."""
    options.setdefault("html", True)
    return compare(original, *simplified, **options)


def _load_mesh(mesh: Any) -> MeshInput:
    """Reads a mesh to measure; decodes the bytes of a file into arrays."""
    source = read_input(mesh, None, "auto")
    if source.file is None:
        return source
    kept = _native.simplify(identity_options(), {}, None, source.file, None, None, None).results[0]
    return read_input((kept.vertices, kept.faces), None, None)


def _comparison(document: Mapping[str, Any], page: str | None) -> Comparison:
    figures = document["figures"]
    return Comparison(
        results=tuple(result["values"] for result in document["results"]),
        units={figure["name"]: figure["unit"] for figure in figures},
        about={figure["name"]: figure["about"] for figure in figures},
        page=page,
    )

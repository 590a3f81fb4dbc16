"""`train`: weights that learn what a function of Python's calls good."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import Given, given


@dataclass(frozen=True)
class Sample:
    """A mesh as an objective sees it."""

    vertices: NDArray[np.float64]
    """n x 3. In a training the mean is the origin and the diagonal of the box 1, and the mesh is turned and stretched as the
    settings say."""
    faces: NDArray[np.int32]
    """m x 3."""
    name: str
    """Of the mesh, or of its file."""
    ratio: float
    """Share of the vertices to keep."""
    vertex_of: NDArray[np.int32] | None = None
    """For a result: result vertex of each vertex of the original."""


Objective = Callable[[Sample, Sample], Any]
"""Error of a result: `objective(original, result)` returns a number of at least 0, or one per vertex or face of the original, which are summed.
One per vertex or face makes the gradients less noisy."""

TrainProgress = Callable[[str, int, int, int, Mapping[str, float]], object]

# What the weights that ship learned with, in the second of their two trainings (`weights/default-2.toml`).
_SETTINGS: dict[str, Any] = {
    "epochs": 10, "learning_rate": 5e-4, "learning_rate_decay": 0.8, "gradient_clip": 0.15, "ratio_min": 0.03, "ratio_max": 0.5,
    "validation_ratios": [0.1], "validation": [],
}  # fmt: skip


def train(
    meshes: str | os.PathLike[str] | Sequence[Any] | Mapping[str, Any],
    objective: Objective | str = "shape",
    *,
    out: str | os.PathLike[str],
    epochs: int | None = None,
    validation: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    init: str | os.PathLike[str] | None = "default",
    resume: bool = False,
    threads: int | None = None,
    progress: TrainProgress | None = None,
) -> str:
    """Trains weights for the closed assembly and returns their file, for `weights=` of `simplify`.

    `meshes` is a folder, or meshes and files by name (or in a list), which are put into `out`. `objective(original, result)` says what is
    wrong with a result; results are simplified as in use, with scores moved up and down, and nothing has to be differentiable. It
    is called from several threads. A name is one of the library's. Meshes whose names begin with an entry of `validation` are kept
    for that. `settings` are those of `docs/training.md`; `init` weights to start from: "default" for those that ship, `None` for none.

    `progress(kind, epoch, done, of, numbers)` is called after each step and epoch. Interrupted, or ended by what it or the
    objective raises, a training goes on with `resume=True` and ends in the same weights.
    """
    judged, name = (judge(objective), None) if callable(objective) else (None, str(objective))
    said = {**_SETTINGS, "validation": list(validation), **(settings or {})}
    place = os.fspath(out)
    data = _folder(meshes, place, resume)
    asked = (data, os.path.join(place, "run"), _toml(said), name, epochs, resume)
    _native.train(asked, judged, _init(init), threads, progress)
    return os.path.join(place, "run", "best.safetensors" if validation else "last.safetensors")


def judge(objective: Objective) -> Callable[..., NDArray[np.float64]]:
    """An objective as the compiled module calls it."""

    def called(name: str, ratio: float, vertices: Any, faces: Any, lighter: Any, lighter_faces: Any, vertex_of: Any) -> NDArray[np.float64]:
        errors = objective(Sample(vertices, faces, name, ratio), Sample(lighter, lighter_faces, name, ratio, vertex_of))
        return np.ascontiguousarray(_plain(errors), np.float64).reshape(-1)

    return called


def _plain(errors: Any) -> Any:
    """A tensor of torch without what it remembers."""
    return errors.detach().cpu().numpy() if hasattr(errors, "detach") else errors


def _init(init: str | os.PathLike[str] | None) -> bytes | None:
    if init is None:
        return None
    if init == "default":
        sizes, tensors, learned = _native.shipped_weights("default")
        return bytes(_native.weights_bytes((dict(sizes), tensors), learned))
    with open(init, "rb") as file:
        return file.read()


def _toml(settings: Mapping[str, Any]) -> str:
    # Strings, numbers, truths and lists of them are in JSON as they are in TOML.
    try:
        return "".join(f"{name} = {json.dumps(value)}\n" for name, value in settings.items())
    except TypeError as error:
        raise _native.OptionError(f"settings: {error}: give numbers, strings, truths or lists of them") from None


def _folder(meshes: Any, place: str, resume: bool) -> str:
    """A folder of the meshes: as given, or written into `place`."""
    if isinstance(meshes, (str, os.PathLike)):
        return os.fspath(meshes)
    named = meshes if isinstance(meshes, Mapping) else {f"mesh-{at:04}": mesh for at, mesh in enumerate(meshes)}
    folder = os.path.join(place, "meshes")
    os.makedirs(folder, exist_ok=resume)
    for name, mesh in named.items():
        if os.path.basename(name) != name or name in ("", ".", ".."):
            raise _native.OptionError(f"meshes: the name {name!r}: give names without folders")
        source = given(mesh, None, None)
        if source.path is None:
            _write(os.path.join(folder, f"{name}.ply"), source)
        else:
            shutil.copyfile(source.path, os.path.join(folder, name + os.path.splitext(source.path)[1]))
    return folder


def _write(path: str, source: Given) -> None:
    """A mesh in memory as a binary PLY, single precision."""
    vertices, faces = (np.asarray(array) for array in source.arrays[:2])
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    rows["n"], rows["v"] = 3, faces
    with open(path, "wb") as file:
        file.write(head.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())

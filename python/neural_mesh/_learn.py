"""Trains weights for an objective that is written in Python."""

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
from ._meshes import MeshInput, read_input


@dataclass(frozen=True)
class Sample:
    """A mesh as an objective sees it."""

    vertices: NDArray[np.float64]
    """Positions, n x 3. Training centers the mesh, scales the diagonal of its bounding box to 1, and rotates and stretches it as the
    settings say."""
    faces: NDArray[np.int32]
    """Vertices of the triangles, m x 3."""
    name: str
    """Name of the mesh or of its file."""
    ratio: float
    """Share of the vertices to keep."""
    vertex_of: NDArray[np.int32] | None = None
    """For a result: result vertex of each vertex of the original."""


Objective = Callable[[Sample, Sample], Any]
"""Error of a result: `objective(original, result)` returns a number of at least 0, or one per vertex or face of the original.

The numbers are summed; one per vertex or face makes the gradients less noisy."""

TrainProgress = Callable[[str, int, int, int, Mapping[str, float]], object]

# Settings of the second training of the shipped weights (`weights/default-2.toml`).
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
    """Trains weights for the closed assembly and returns the path of their file, for the option `weights` of `simplify`.

    - `meshes`: a folder, or a mapping or list of meshes and files, which are copied into `out`
    - `objective`: `objective(original, result)` returns the error of a result. It is called from several threads and need not be
      differentiable: gradients come from results with perturbed scores. A string names one of the library's objectives
    - `validation`: meshes whose names begin with one of these are used for validation only
    - `settings`: the settings of `docs/training.md`, by name
    - `init`: weights to start from: "default" for the shipped ones, the path of a file, or `None` for random weights
    - `progress`: `progress(kind, epoch, done, of, numbers)` is called after each step and epoch
    - `resume`: continues a training that was interrupted or that an exception ended; the final weights are those of an
      uninterrupted training

    Raises `OptionError` for a wrong setting, and passes on what the objective raises.
    """
    judge_result, name = (judge(objective), None) if callable(objective) else (None, str(objective))
    toml_settings = {**_SETTINGS, "validation": list(validation), **(settings or {})}
    folder = os.fspath(out)
    data = _prepare_folder(meshes, folder, resume)
    asked = (data, os.path.join(folder, "run"), _toml(toml_settings), name, epochs, resume)
    _native.train(asked, judge_result, _read_init(init), threads, progress)
    return os.path.join(folder, "run", "best.safetensors" if validation else "last.safetensors")


def judge(objective: Objective) -> Callable[..., NDArray[np.float64]]:
    """Wraps an objective for the compiled module: arrays in, a flat array of errors out."""

    def called(name: str, ratio: float, vertices: Any, faces: Any, lighter: Any, lighter_faces: Any, vertex_of: Any) -> NDArray[np.float64]:
        errors = objective(Sample(vertices, faces, name, ratio), Sample(lighter, lighter_faces, name, ratio, vertex_of))
        return np.ascontiguousarray(_to_array(errors), np.float64).reshape(-1)

    return called


def _to_array(errors: Any) -> Any:
    """Returns a torch tensor as an array without its gradient graph, and anything else unchanged."""
    return errors.detach().cpu().numpy() if hasattr(errors, "detach") else errors


def _read_init(init: str | os.PathLike[str] | None) -> bytes | None:
    if init is None:
        return None
    if init == "default":
        sizes, tensors, learned = _native.shipped_weights("default")
        return bytes(_native.weights_bytes((dict(sizes), tensors), learned))
    with open(init, "rb") as file:
        return file.read()


def _toml(settings: Mapping[str, Any]) -> str:
    # JSON and TOML spell strings, numbers, booleans and lists of them alike.
    try:
        return "".join(f"{name} = {json.dumps(value)}\n" for name, value in settings.items())
    except TypeError as error:
        raise _native.OptionError(f"settings: {error}: give numbers, strings, booleans or lists of them") from None


def _prepare_folder(meshes: Any, folder: str, resume: bool) -> str:
    """Returns the folder of the meshes; a mapping or list is written into `folder` first."""
    if isinstance(meshes, (str, os.PathLike)):
        return os.fspath(meshes)
    meshes_by_name = meshes if isinstance(meshes, Mapping) else {f"mesh-{at:04}": mesh for at, mesh in enumerate(meshes)}
    folder = os.path.join(folder, "meshes")
    os.makedirs(folder, exist_ok=resume)
    for name, mesh in meshes_by_name.items():
        if os.path.basename(name) != name or name in ("", ".", ".."):
            raise _native.OptionError(f"meshes: the name {name!r}: give names without folders")
        source = read_input(mesh, None, None)
        if source.path is None:
            _write_ply(os.path.join(folder, f"{name}.ply"), source)
        elif os.path.realpath(os.path.dirname(os.path.abspath(source.path))) == os.path.realpath(folder):
            raise _native.OptionError(f"meshes: {source.path} is in the folder of the copies: give that folder alone, or another `out`")
        else:
            shutil.copyfile(source.path, os.path.join(folder, name + os.path.splitext(source.path)[1]))
    return folder


def _write_ply(path: str, source: MeshInput) -> None:
    """Writes a mesh in memory as a binary PLY file in single precision."""
    vertices, faces = (np.asarray(array) for array in source.arrays[:2])
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    rows["n"], rows["v"] = 3, faces
    with open(path, "wb") as file:
        file.write(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())

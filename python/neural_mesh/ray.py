"""Simplifies millions of mesh files with Ray, with a manifest of one row per mesh.

The rows are those of the program's `manifest.csv`. A mesh that fails, exceeds the timeout, or crashes its worker three times gets a row
that says so. Files are written atomically. A mesh with a row of success and an output file is not simplified again.

Meshes and outputs are paths or any URL of fsspec (`s3://...`).
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import posixpath
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import ray

from ._native import NeuralMeshError
from ._result import NotReachedError
from ._simplify import simplify

__all__ = ["COLUMNS", "each", "simplify_all"]

COLUMNS = (
    "name", "output", "vertices", "faces", "output_vertices", "output_faces", "mean_percent", "max_percent", "seconds", "outcome", "request",
)  # fmt: skip

_ENDINGS = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".3mf")
# Worker crashes after which a mesh counts as failed.
_MAX_CRASHES = 3
# Largest number of meshes per block: handing a block to a worker takes Ray some hundredths of a second.
_MESHES_PER_BLOCK = 16
# Seconds between two writes of the manifest.
_MANIFEST_INTERVAL = 1.0


def simplify_all(
    meshes: str | Iterable[str],
    out: str,
    *,
    workers: int,
    threads: int = 1,
    timeout: float = 600.0,
    format: str | None = None,
    resume: bool = False,
    **options: Any,
) -> list[dict[str, Any]]:
    """Simplifies every mesh into a file of its name in the folder `out`, with a manifest, and returns the manifest's rows.

    - `meshes`: a folder, a Parquet file with a column `path`, or a list of paths
    - `workers`, `threads`: number of Ray actors, and threads of each
    - `timeout`: seconds per mesh
    - `format`: format of all results; that of the input by default
    - `resume`: keeps finished results; without it an existing `manifest.csv` is an error
    - `options`: those of `simplify`; `check=True` fills the distances

    Raises `NeuralMeshError` if a manifest exists; errors of single meshes only show in their rows.
    """
    found = list(_list_meshes(meshes))
    request = json.dumps({**options, "format": format}, sort_keys=True, default=str)
    names = _name_outputs(found, format)
    read = {_identify(path) for _, path in found}
    for target in (_join(out, output) for output in names):
        if _identify(target) in read:
            raise NeuralMeshError(f"{target}: is one of the meshes, which are never replaced: choose another folder")
    rows = {name: _pending_row(name, output, request) for (name, _), output in zip(found, names)}
    manifest = _join(out, "manifest.csv")
    if _exists(manifest) and not resume:
        raise NeuralMeshError(f"{manifest}: exists already: choose another folder, or go on with resume=True")
    done = _read_done(manifest, out, request) if resume else {}
    rows.update({name: row for name, row in done.items() if name in rows})
    left = [{"name": name, "path": path, "output": rows[name]["output"]} for name, path in found if name not in done]
    _write_manifest(manifest, rows.values())
    for row in _iterate_rows(left, out, request, workers, threads, timeout, options):
        rows[row["name"]] = row
        _write_manifest(manifest, rows.values(), interval=_MANIFEST_INTERVAL)
    _write_manifest(manifest, rows.values())
    _remove(_join(out, ".falls"))
    return list(rows.values())


def each(function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
    """Maps a function over items as Ray tasks, and repeats tasks whose worker crashed.

    It is meant for `neural_mesh.blocks.simplify(mesh, ratio=0.01, each=each, threads=1)`."""
    task = ray.remote(max_retries=-1)(_call)
    return list(ray.get([task.remote(function, item) for item in items]))


def _call(function: Callable[[Any], Any], item: Any) -> Any:
    return function(item)


def _iterate_rows(
    left: Sequence[Mapping[str, str]], out: str, request: str, workers: int, threads: int, timeout: float, options: Mapping[str, Any]
) -> Iterator[dict[str, Any]]:
    """Yields the row of each mesh when it is done; crashed workers are restarted and repeat their mesh."""
    if not left:
        return
    n_blocks = min(len(left), max(len(left) // _MESHES_PER_BLOCK, 8 * workers))
    data = ray.data.from_items([dict(item) for item in left], override_num_blocks=n_blocks)
    of_worker = {"out": out, "request": request, "threads": threads, "timeout": timeout, "options": dict(options)}
    done = data.map(
        _Worker, fn_constructor_kwargs=of_worker, compute=ray.data.ActorPoolStrategy(size=workers), num_cpus=threads,
        max_restarts=-1, max_task_retries=-1,
    )  # fmt: skip
    for row in done.iter_rows():
        yield {name: row[name] for name in COLUMNS}


class _Worker:
    """An actor that simplifies one mesh after another."""

    def __init__(self, out: str, request: str, threads: int, timeout: float, options: dict[str, Any]) -> None:
        self._out, self._request, self._threads, self._timeout, self._options = out, request, threads, timeout, options

    def __call__(self, item: dict[str, Any]) -> dict[str, Any]:
        row, began = _pending_row(item["name"], item["output"], self._request), time.perf_counter()
        crashes = _CrashCounter(self._out, item["name"])
        try:
            if crashes.begin() >= _MAX_CRASHES:
                raise NeuralMeshError(f"crashed its worker {_MAX_CRASHES} times: leave the mesh out")
            self._simplify(item, row, began)
        except Exception as error:  # noqa: BLE001  every failure becomes a row
            row["outcome"] = "failed: " + (" ".join(str(error).split()) or type(error).__name__)
        crashes.end()
        row["seconds"] = time.perf_counter() - began
        return row

    def _simplify(self, item: Mapping[str, str], row: dict[str, Any], began: float) -> None:
        def in_time(done: float, stage: str) -> None:
            if time.perf_counter() - began > self._timeout:
                raise TimeoutError(f"took more than {self._timeout:g} seconds: raise the timeout, or leave the mesh out")

        with tempfile.TemporaryDirectory() as folder:
            source = _fetch(item["path"], folder)
            target_path = os.path.join(folder, "out", posixpath.basename(item["output"]))
            os.mkdir(os.path.dirname(target_path))
            try:
                light = simplify(source, out=target_path, threads=self._threads, progress=in_time, **self._options)
            except NotReachedError as short:
                light = short.result
            _publish(os.path.dirname(target_path), os.path.basename(target_path), _join(self._out, item["output"]))
        report = light.report
        distance: Any = report["distance"] or {}
        row.update({name: report["input"][name] for name in ("vertices", "faces")})
        row.update({f"output_{name}": report["output"][name] for name in ("vertices", "faces")})
        row.update({name: distance.get(name) for name in ("mean_percent", "max_percent")}, outcome=light.outcome)


class _CrashCounter:
    """Counts the crashes of a mesh in a file, which outlives the worker: one line per start, deleted at the end."""

    def __init__(self, out: str, name: str) -> None:
        self._path = _join(out, ".falls", hashlib.sha256(name.encode()).hexdigest()[:32])

    def begin(self) -> int:
        fs, path = _fs(self._path)
        before = fs.cat_file(path) if fs.exists(path) else b""
        fs.makedirs(posixpath.dirname(path), exist_ok=True)
        fs.pipe_file(path, before + f"{os.getpid()}\n".encode())
        return int(before.count(b"\n"))

    def end(self) -> None:
        fs, path = _fs(self._path)
        if fs.exists(path):
            fs.rm_file(path)


def _pending_row(name: str, output: str, request: str) -> dict[str, Any]:
    return {**dict.fromkeys(COLUMNS), "name": name, "output": output, "outcome": "pending", "request": request}


def _fs(url: str) -> tuple[Any, str]:
    import fsspec

    fs, path = fsspec.core.url_to_fs(url)
    return fs, path


def _identify(url: str) -> Any:
    """Returns device and inode of a local file, or the URL of anything else."""
    try:
        found = os.stat(url)
    except OSError:
        return url
    return found.st_dev, found.st_ino


def _join(*parts: str) -> str:
    return posixpath.join(*parts)


def _exists(url: str) -> bool:
    fs, path = _fs(url)
    return bool(fs.exists(path))


def _remove(url: str) -> None:
    fs, path = _fs(url)
    if fs.exists(path):
        fs.rm(path, recursive=True)


def _list_meshes(meshes: str | Iterable[str]) -> Iterator[tuple[str, str]]:
    """Lists names and paths of meshes; names in a folder are relative to it."""
    if not isinstance(meshes, str):
        for path in meshes:
            yield path, path
    elif meshes.endswith((".parquet", ".pq")):
        for row in ray.data.read_parquet(meshes).iter_rows():
            yield row["path"], row["path"]
    else:
        fs, folder = _fs(meshes)
        for path in sorted(fs.find(folder)):
            bare = path.removesuffix(".gz").lower()
            if bare.endswith(_ENDINGS):
                yield posixpath.relpath(path, folder), fs.unstrip_protocol(path) if "://" in meshes else path


def _name_outputs(found: Sequence[tuple[str, str]], format: str | None) -> list[str]:
    """Returns a unique output path for each mesh, relative to the output folder."""
    taken: set[str] = set()
    outputs = []
    for name, _ in found:
        stem, ending = posixpath.splitext(name.split("://")[-1].lstrip("/").replace("..", "_"))
        target_path, number = stem + (f".{format}" if format else ending), 1
        while target_path in taken:
            number += 1
            target_path = f"{stem}-{number}" + (f".{format}" if format else ending)
        taken.add(target_path)
        outputs.append(target_path)
    return outputs


def _read_done(manifest: str, out: str, request: str) -> dict[str, dict[str, Any]]:
    """Returns the manifest's rows of success that have equal options and an output file."""
    fs, path = _fs(manifest)
    if not fs.exists(path):
        return {}
    rows = csv.DictReader(io.StringIO(fs.cat_file(path).decode()))
    is_done = ("reached", "stopped: ")
    kept = (row for row in rows if row["outcome"].startswith(is_done) and row["request"] == request)
    return {row["name"]: dict(row) for row in kept if _exists(_join(out, row["output"]))}


_LAST_WRITES: dict[str, float] = {}


def _write_manifest(manifest: str, rows: Iterable[Mapping[str, Any]], interval: float = 0.0) -> None:
    """Writes the whole manifest, unless the last write was less than `interval` seconds ago."""
    now = time.monotonic()
    if now - _LAST_WRITES.get(manifest, -1e9) < interval:
        return
    _LAST_WRITES[manifest] = now
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    with tempfile.TemporaryDirectory() as folder:
        name = posixpath.basename(manifest)
        with open(os.path.join(folder, name), "w", newline="") as file:
            file.write(text.getvalue())
        _publish(folder, name, manifest)


def _fetch(url: str, folder: str) -> str:
    """Returns the path of a local file; downloads a URL into the folder first."""
    if "://" not in url:
        return url
    fs, path = _fs(url)
    target_path = os.path.join(folder, posixpath.basename(path))
    fs.get_file(path, target_path)
    return target_path


def _publish(folder: str, name: str, url: str) -> None:
    """Copies the files of a folder next to the target URL, `name` last; each file appears atomically."""
    fs, target = _fs(url)
    fs.makedirs(posixpath.dirname(target), exist_ok=True)
    others = [other for other in os.listdir(folder) if other != name]
    for file, target_path in [*((other, posixpath.join(posixpath.dirname(target), other)) for other in others), (name, target)]:
        # A texture or buffer there may belong to a mesh that is read.
        if file != name and fs.exists(target_path):
            with open(os.path.join(folder, file), "rb") as made:
                if fs.cat_file(target_path) == made.read():
                    continue
            raise NeuralMeshError(f"{target_path}: exists already with other content: choose another folder")
        if getattr(fs, "local_file", False) or "file" in fs.protocol:
            temporary = f"{target_path}.{os.getpid()}.part"
            shutil.copyfile(os.path.join(folder, file), temporary)
            os.replace(temporary, target_path)
        else:
            # Object stores show an upload only when it is complete.
            fs.put_file(os.path.join(folder, file), target_path)

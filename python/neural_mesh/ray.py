"""Millions of meshes by Ray: files in, files out, a row for each, whatever becomes of it.

The rows are those of the program's `manifest.csv`. A mesh that fails is a row; one that takes too long is; one that takes its worker
down three times is. Every file appears whole or not at all. What has a row of success, and its file, is not done again.

Names may be paths or any URL of fsspec (`s3://...`), also that of the manifest.
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
# Workers that a mesh may take down before it counts as failed.
_MOST_FALLS = 3
# Meshes that a worker is handed at once, at most: Ray takes some hundredths of a second to hand them over.
_AT_ONCE = 16
# Seconds between two writes of the manifest.
_PATIENCE = 1.0


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
    """Simplifies every mesh into a file of its name below `out`, and keeps `manifest.csv` there; gives its rows in order.

    `meshes` is a folder, a Parquet file with a column `path`, or names. `workers` actors of Ray with `threads` threads each take
    them as they are free. `timeout` is in seconds for each mesh. Options are those of `simplify`; `check=True` fills the distances.
    With `resume` what is done already stays; without, a manifest that is there is refused.
    """
    found = list(_found(meshes))
    request = json.dumps({**options, "format": format}, sort_keys=True, default=str)
    names = _outputs(found, format)
    rows = {name: _row(name, output, request) for (name, _), output in zip(found, names)}
    manifest = _join(out, "manifest.csv")
    if _exists(manifest) and not resume:
        raise NeuralMeshError(f"{manifest}: exists already: choose another folder, or go on with resume=True")
    done = _done(manifest, out, request) if resume else {}
    rows.update({name: row for name, row in done.items() if name in rows})
    left = [{"name": name, "path": path, "output": rows[name]["output"]} for name, path in found if name not in done]
    _write_manifest(manifest, rows.values())
    for row in _rows(left, out, request, workers, threads, timeout, options):
        rows[row["name"]] = row
        _write_manifest(manifest, rows.values(), patience=_PATIENCE)
    _write_manifest(manifest, rows.values())
    _remove(_join(out, ".falls"))
    return list(rows.values())


def each(function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
    """What a function gives for each item, made by whoever in the cluster is free, again where a worker falls: for
    `neural_mesh.blocks.simplify(mesh, ratio=0.01, each=each, threads=1)`."""
    task = ray.remote(max_retries=-1)(_called)
    return list(ray.get([task.remote(function, item) for item in items]))


def _called(function: Callable[[Any], Any], item: Any) -> Any:
    return function(item)


def _rows(
    left: Sequence[Mapping[str, str]], out: str, request: str, workers: int, threads: int, timeout: float, options: Mapping[str, Any]
) -> Iterator[dict[str, Any]]:
    """A row for each mesh, as they come; a worker that falls is started anew, and what it was at is done again."""
    if not left:
        return
    n_blocks = min(len(left), max(len(left) // _AT_ONCE, 8 * workers))
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
        row, began = _row(item["name"], item["output"], self._request), time.perf_counter()
        falls = _Falls(self._out, item["name"])
        try:
            if falls.begin() >= _MOST_FALLS:
                raise NeuralMeshError(f"crashed its worker {_MOST_FALLS} times: leave the mesh out")
            self._simplify(item, row, began)
        except Exception as error:  # noqa: BLE001  whatever it is, it is a row
            row["outcome"] = "failed: " + (" ".join(str(error).split()) or type(error).__name__)
        falls.end()
        row["seconds"] = time.perf_counter() - began
        return row

    def _simplify(self, item: Mapping[str, str], row: dict[str, Any], began: float) -> None:
        def in_time(done: float, stage: str) -> None:
            if time.perf_counter() - began > self._timeout:
                raise TimeoutError(f"took more than {self._timeout:g} seconds: raise the timeout, or leave the mesh out")

        with tempfile.TemporaryDirectory() as folder:
            source = _fetched(item["path"], folder)
            place = os.path.join(folder, "out", posixpath.basename(item["output"]))
            os.mkdir(os.path.dirname(place))
            try:
                light = simplify(source, out=place, threads=self._threads, progress=in_time, **self._options)
            except NotReachedError as short:
                light = short.result
            _put(os.path.dirname(place), os.path.basename(place), _join(self._out, item["output"]))
        report = light.report
        distance: Any = report["distance"] or {}
        row.update({name: report["input"][name] for name in ("vertices", "faces")})
        row.update({f"output_{name}": report["output"][name] for name in ("vertices", "faces")})
        row.update({name: distance.get(name) for name in ("mean_percent", "max_percent")}, outcome=light.outcome)


class _Falls:
    """How often a mesh was begun and not ended: a file of its own, so that it outlives its worker, with a line for each: its process."""

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


def _row(name: str, output: str, request: str) -> dict[str, Any]:
    return {**dict.fromkeys(COLUMNS), "name": name, "output": output, "outcome": "pending", "request": request}


def _fs(url: str) -> tuple[Any, str]:
    import fsspec

    fs, path = fsspec.core.url_to_fs(url)
    return fs, path


def _join(*parts: str) -> str:
    return posixpath.join(*parts)


def _exists(url: str) -> bool:
    fs, path = _fs(url)
    return bool(fs.exists(path))


def _remove(url: str) -> None:
    fs, path = _fs(url)
    if fs.exists(path):
        fs.rm(path, recursive=True)


def _found(meshes: str | Iterable[str]) -> Iterator[tuple[str, str]]:
    """Names and places of meshes; those of a folder are named by their paths below it."""
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


def _outputs(found: Sequence[tuple[str, str]], format: str | None) -> list[str]:
    """Where results go, below the folder of all of them: no two to one place."""
    taken: set[str] = set()
    outputs = []
    for name, _ in found:
        stem, ending = posixpath.splitext(name.split("://")[-1].lstrip("/").replace("..", "_"))
        place, number = stem + (f".{format}" if format else ending), 1
        while place in taken:
            number += 1
            place = f"{stem}-{number}" + (f".{format}" if format else ending)
        taken.add(place)
        outputs.append(place)
    return outputs


def _done(manifest: str, out: str, request: str) -> dict[str, dict[str, Any]]:
    """Rows of what is done, as asked for now, and whose file is there."""
    fs, path = _fs(manifest)
    if not fs.exists(path):
        return {}
    rows = csv.DictReader(io.StringIO(fs.cat_file(path).decode()))
    is_done = ("reached", "stopped: ")
    kept = (row for row in rows if row["outcome"].startswith(is_done) and row["request"] == request)
    return {row["name"]: dict(row) for row in kept if _exists(_join(out, row["output"]))}


_WRITTEN: dict[str, float] = {}


def _write_manifest(manifest: str, rows: Iterable[Mapping[str, Any]], patience: float = 0.0) -> None:
    """The manifest as a whole, not more often than once in so many seconds."""
    now = time.monotonic()
    if now - _WRITTEN.get(manifest, -1e9) < patience:
        return
    _WRITTEN[manifest] = now
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    with tempfile.TemporaryDirectory() as folder:
        name = posixpath.basename(manifest)
        with open(os.path.join(folder, name), "w", newline="") as file:
            file.write(text.getvalue())
        _put(folder, name, manifest)


def _fetched(url: str, folder: str) -> str:
    """The mesh as a file here."""
    if "://" not in url:
        return url
    fs, path = _fs(url)
    place = os.path.join(folder, posixpath.basename(path))
    fs.get_file(path, place)
    return place


def _put(folder: str, name: str, url: str) -> None:
    """The files of a folder beside the place of `name`, which comes last; each appears whole."""
    fs, target = _fs(url)
    fs.makedirs(posixpath.dirname(target), exist_ok=True)
    others = [other for other in os.listdir(folder) if other != name]
    for file, place in [*((other, posixpath.join(posixpath.dirname(target), other)) for other in others), (name, target)]:
        if getattr(fs, "local_file", False) or "file" in fs.protocol:
            beside = f"{place}.{os.getpid()}.part"
            shutil.copyfile(os.path.join(folder, file), beside)
            os.replace(beside, place)
        else:
            # Stores of objects show an upload when it is complete.
            fs.put_file(os.path.join(folder, file), place)

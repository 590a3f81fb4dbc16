"""Takes scenes out of clones of public repositories, bare or not; nothing of them is part of this one."""

import csv
import posixpath
import subprocess
from dataclasses import dataclass
from pathlib import Path

import gltf

TABLE = Path(__file__).resolve().parent.parent / "scenes.csv"


@dataclass
class Source:
    """A scene by the repository that publishes it."""

    name: str
    repository: str  # owner/name
    path: str


def read_table():
    with TABLE.open(newline="") as file:
        return [Source(**row) for row in csv.DictReader(file)]


def find_clone(repositories, repository):
    """Returns the folder of a clone, as OWNER+NAME/repo, OWNER+NAME or OWNER/NAME; None where there is none."""
    flat = repositories / repository.replace("/", "+")
    return next((folder for folder in (flat / "repo", flat, repositories / repository) if folder.is_dir()), None)


def read_blob(clone, path):
    """Returns a file at the head of a clone; None where the clone lacks it or holds a pointer of Git LFS."""
    shown = subprocess.run(["git", "-C", clone, "show", f"HEAD:{path}"], capture_output=True)
    is_pointer = shown.stdout.startswith(b"version https://git-lfs")
    return None if shown.returncode or is_pointer else shown.stdout


def extract(source, repositories, folder):
    """Writes a scene and the files that it refers to into a folder; returns the path of its main file.

    Raises `gltf.Unsupported` where the clone lacks the scene or one of its buffers; images may be missing.
    """
    main = folder / posixpath.basename(source.path)
    if main.exists():
        return main
    clone = find_clone(repositories, source.repository)
    if clone is None:
        raise gltf.Unsupported(f"no clone of {source.repository}")
    data = read_blob(clone, source.path)
    if data is None:
        raise gltf.Unsupported("not in the clone")
    folder.mkdir(parents=True, exist_ok=True)
    unfinished = main.with_suffix(".part")
    unfinished.write_bytes(data)
    buffers, images = gltf.find_referred_files(gltf.read_document(unfinished)[0])
    for path in buffers + images:
        inside = posixpath.normpath(path)
        blob = read_blob(clone, posixpath.normpath(posixpath.join(posixpath.dirname(source.path), path)))
        if blob is None and path in buffers:
            raise gltf.Unsupported(f"its buffer {path} is not in the clone")
        if blob is not None and not inside.startswith(".."):
            (folder / inside).parent.mkdir(parents=True, exist_ok=True)
            (folder / inside).write_bytes(blob)
    return unfinished.rename(main)

"""Simplification with Ray: one row per mesh, files independent of crashes, no work done twice."""

from __future__ import annotations

import csv
import os
import random
import signal
import threading
import time
from pathlib import Path
from typing import Any

import pytest

ray = pytest.importorskip("ray")

import neural_mesh as nm  # noqa: E402
from conftest import torus  # noqa: E402
from neural_mesh import blocks  # noqa: E402
from neural_mesh.ray import COLUMNS, each, simplify_all  # noqa: E402

N = 60


@pytest.fixture(scope="module", autouse=True)
def cluster() -> Any:
    paths = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    ray.init(num_cpus=3, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": paths}})
    yield
    ray.shutdown()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder of meshes, 3 % of them broken, some in subfolders."""
    folder = tmp_path_factory.mktemp("meshes")
    (folder / "deep").mkdir()
    for number in range(N):
        place = folder / ("deep" if number % 4 == 0 else ".") / f"{number}.ply"
        if number % 30 == 7:
            place.write_bytes(b"ply\nformat ascii 1.0\nelement vertex 3\n")
        else:
            nm.simplify(torus(40 + number, 30), ratio=1.0, out=place)
    return folder


def results(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*.ply")}


def test_every_mesh_has_a_row_after_crashes(folder: Path, tmp_path: Path) -> None:
    calm = simplify_all(str(folder), str(tmp_path / "calm"), workers=2, ratio=0.2, check=True)
    is_over = threading.Event()
    killed: list[int] = []

    def kill() -> None:
        """Kills three workers, each by its process id."""
        while not is_over.is_set() and len(killed) < 3:
            time.sleep(0.02)
            at_work = find_running_processes(tmp_path / "killed") - set(killed)
            if at_work:
                victim = random.Random(len(killed)).choice(sorted(at_work))
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)
                time.sleep(1.0)

    thread = threading.Thread(target=kill)
    thread.start()
    rows = simplify_all(str(folder), str(tmp_path / "killed"), workers=2, ratio=0.2, check=True)
    is_over.set()
    thread.join()
    assert len(killed) == 3
    assert [row["name"] for row in rows] == [row["name"] for row in calm] and len(rows) == N
    for row, other in zip(rows, calm):
        assert {**row, "seconds": 0} == {**other, "seconds": 0}
    assert results(tmp_path / "killed") == results(tmp_path / "calm")
    failed = [row for row in rows if row["outcome"].startswith("failed: ")]
    assert len(failed) == 2 and len(results(tmp_path / "calm")) == N - 2
    assert all(row["mean_percent"] > 0 for row in rows if row["outcome"] == "reached")
    with open(tmp_path / "killed" / "manifest.csv", newline="") as file:
        written = list(csv.DictReader(file))
    assert tuple(written[0]) == COLUMNS and [row["outcome"] for row in written] == [row["outcome"] for row in rows]
    assert not list((tmp_path / "killed").rglob("*.part")) and not (tmp_path / "killed" / ".falls").exists()


def find_running_processes(out: Path) -> set[int]:
    """Returns the process ids of unfinished meshes."""
    try:
        return {int(path.read_text().split()[-1]) for path in (out / ".falls").iterdir()}
    except (OSError, IndexError):
        return set()


def test_resume_does_only_missing_meshes(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    names = [str(path) for path in sorted(folder.glob("*.ply"))[:6]]
    first = simplify_all(names[:4], str(out), workers=1, faces=300)
    kept = {row["output"]: (out / row["output"]).stat().st_mtime_ns for row in first if row["outcome"] == "reached"}
    (out / first[0]["output"]).unlink()
    with pytest.raises(nm.NeuralMeshError, match="resume=True"):
        simplify_all(names, str(out), workers=1, faces=300)
    rows = simplify_all(names, str(out), workers=1, faces=300, resume=True)
    assert len(rows) == 6 and (out / first[0]["output"]).exists()
    same = [name for name, at in kept.items() if (out / name).stat().st_mtime_ns == at]
    assert len(same) == len(kept) - 1


def test_blocks_on_workers() -> None:
    mesh = torus(1200, 500)
    alone, several = (blocks.simplify(mesh, ratio=0.01, each=how, threads=1) for how in (map, each))
    assert all((x == y).all() for x, y in zip(alone, several, strict=True))


def test_timeout_is_a_row(tmp_path: Path) -> None:
    place = tmp_path / "large.ply"
    nm.simplify(torus(1000, 500), ratio=1.0, out=place)
    rows = simplify_all([str(place)], str(tmp_path / "out"), workers=1, timeout=0.05, ratio=0.5)
    assert rows[0]["outcome"].startswith("failed: more than 0.05 seconds")


def test_parquet_file_and_urls(folder: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    names = [str(path) for path in sorted(folder.glob("1*.ply"))[:3]]
    pandas.DataFrame({"path": [f"file://{name}" for name in names]}).to_parquet(tmp_path / "meshes.parquet")
    rows = simplify_all(str(tmp_path / "meshes.parquet"), f"file://{tmp_path}/out", workers=1, ratio=0.2, format="stl")
    assert [row["outcome"] for row in rows].count("reached") == len(rows)
    assert all((tmp_path / "out" / row["output"]).exists() and row["output"].endswith(".stl") for row in rows)

"""Files are read and written as by the program."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import neural_mesh as nm
from conftest import MESHES, grid, torus

PROGRAM = os.environ.get("NEURAL_MESH_PROGRAM", "")


def test_file_to_arrays(spot: Path) -> None:
    light = nm.simplify(spot, ratio=0.1)
    assert (len(light.vertices), light.report["input"]["vertices"]) == (293, 2930)
    assert light.vertices.dtype == np.float64 and light.paths == ()


def test_file_to_file(spot: Path, tmp_path: Path) -> None:
    out = tmp_path / "light.glb"
    light = nm.simplify(str(spot), faces=500, out=out, report=tmp_path / "report.json", picture=tmp_path / "light.png")
    assert light.paths == (str(out),) and len(light.faces) == 500
    assert out.read_bytes()[:4] == b"glTF" and (tmp_path / "light.png").read_bytes()[1:4] == b"PNG"
    with pytest.raises(nm.NeuralMeshError, match="exists already"):
        nm.simplify(spot, faces=500, out=out)
    nm.simplify(spot, faces=400, out=out, force=True)
    assert len(nm.simplify(out, ratio=1.0).faces) == 400


@pytest.mark.skipif(not PROGRAM, reason="the program is not named by NEURAL_MESH_PROGRAM")
@pytest.mark.parametrize("name", ["light.ply", "light.obj", "light.glb", "light.stl"])
def test_bytes_equal_the_program(spot: Path, tmp_path: Path, name: str) -> None:
    ours, theirs = tmp_path / name, tmp_path / "program" / name
    theirs.parent.mkdir()
    source = MESHES / "spot.obj" if (MESHES / "spot.obj").exists() else spot
    nm.simplify(source, ratio=0.1, out=ours)
    subprocess.run([PROGRAM, "simplify", str(source), "-o", str(theirs), "--ratio", "0.1", "--quiet"], check=True)
    assert ours.read_bytes() == theirs.read_bytes()


def test_paths_that_look_like_options(spot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    nm.simplify(spot, ratio=0.5, out="--force.ply")
    light = nm.simplify("--force.ply", ratio=0.5, out="-o.ply", report="-r.json")
    assert Path("-o.ply").exists() and Path("-r.json").exists() and light.paths == ("-o.ply",)
    with pytest.raises(nm.NeuralMeshError, match="exists already"):
        nm.simplify(spot, ratio=0.5, out="--force.ply")


def test_lods_write_files(spot: Path, tmp_path: Path) -> None:
    levels = nm.lods(spot, [0.5, 0.1], out=tmp_path / "spot.ply")
    assert [Path(path).name for path in levels[0].paths] == ["spot-lod0.ply", "spot-lod1.ply"]
    assert len(nm.simplify(levels[0].paths[1], ratio=1.0).vertices) == len(levels[1].vertices)


def test_size_in_bytes(spot: Path, tmp_path: Path) -> None:
    out = tmp_path / "small.ply"
    nm.simplify(spot, size="20kB", out=out)
    assert 19_000 < out.stat().st_size <= 20_000


def test_arrays_to_file_with_attributes(tmp_path: Path) -> None:
    vertices, faces, uv = grid(30)
    out = tmp_path / "grid.obj"
    colours = (np.stack([vertices[:, 0], vertices[:, 1], vertices[:, 0]], 1) * 255).astype(np.uint8)
    light = nm.simplify((vertices, faces), ratio=0.2, attributes={"uv": uv, "colors": colours}, out=out)
    again = nm.simplify(out, ratio=1.0)
    assert len(again.faces) == len(light.faces)
    np.testing.assert_allclose(again.corners("uv"), light.corners("uv"), atol=1e-6)


def test_scene_stays_a_scene(tmp_path: Path) -> None:
    scene, light_scene = tmp_path / "scene.glb", tmp_path / "light.glb"
    nm.simplify(torus(60, 40), ratio=1.0, out=scene)
    light = nm.simplify(scene, ratio=0.1, out=light_scene)
    assert len(light.vertices) == 240 == light.report["output"]["vertices"]
    assert len(nm.simplify(light_scene, ratio=1.0).vertices) == 240


def test_comparison_writes_page(tmp_path: Path) -> None:
    mesh = torus(40, 30)
    light = nm.simplify(mesh, ratio=0.2)
    shown = nm.show(mesh, light)
    assert shown.page is not None and shown.page.startswith("<!") and "<iframe" in shown._repr_html_()
    page = tmp_path / "page.html"
    nm.compare(mesh, light, html=page)
    assert page.read_text() == shown.page
    with pytest.raises(nm.NeuralMeshError, match="exists already"):
        nm.compare(mesh, light, html=page)
    assert "<table>" in nm.compare(mesh, light)._repr_html_()


def test_point_cloud_file(spot: Path, tmp_path: Path) -> None:
    out = tmp_path / "points.ply"
    light = nm.mesh_points(spot, ratio=0.5, out=out)
    assert out.exists() and len(light.faces) > 1000

"""Progressions make meshes of any size from one collapse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import edge_counts, grid, torus


def test_levels_have_the_size_and_type_asked() -> None:
    vertices, faces = torus(60, 30)
    made = nm.progression((vertices, faces))
    assert (made.n_vertices, made.n_faces) == (1800, 3600)
    for refined in (True, False):
        light = made.at_faces(1000, refined=refined)
        assert light.faces.shape == (1000, 3) and light.vertices.dtype == np.float32
        assert (edge_counts(light.faces) == 2).all()
        assert len(made.at_vertices("10%", refined=refined).vertices) == 180
    single = nm.simplify((vertices, faces), faces=1000)
    assert len(single.faces) == len(made.at_faces(1000).faces)


def test_a_file_is_read_again(tmp_path: Path) -> None:
    made = nm.progression(torus(40, 20, np.float64))
    path = made.save(tmp_path / "torus.nmp")
    with pytest.raises(nm.NeuralMeshError, match="exists already"):
        made.save(path)
    made.save(path, force=True)
    for read in (nm.load_progression(path), nm.load_progression(made.to_bytes())):
        for refined in (True, False):
            np.testing.assert_array_equal(read.at_faces(400, refined=refined).vertices, made.at_faces(400, refined=refined).vertices)
    mesh = nm.simplify(torus(40, 20), ratio=1.0).save(tmp_path / "torus.ply")
    before = Path(mesh).read_bytes()
    with pytest.raises(nm.NeuralMeshError, match="is read in this run"):
        nm.progression(mesh).save(mesh, force=True)
    assert Path(mesh).read_bytes() == before
    written = made.at_faces(400, out=tmp_path / "light.ply")
    assert written.paths == (str(tmp_path / "light.ply"),)
    with pytest.raises(nm.NeuralMeshError, match="not a progression"):
        nm.load_progression(b"solid nothing")


def test_attributes_are_carried() -> None:
    vertices, faces, uv = grid(20)
    made: Any = nm.progression((vertices, faces), attributes={"uv": uv})
    for refined in (True, False):
        light = made.at_vertices(100, refined=refined)
        corners = light.corners("uv")
        chart = corners[..., :1] > 1.5
        assert np.abs(np.asarray(light.vertices)[light.faces][..., :2] + 2 * chart - corners).max() < 0.1


def test_distances_are_proved_on_request() -> None:
    mesh = torus(40, 20)
    made = nm.progression(mesh, prove=True)
    distances = [distance for _, distance in made.proved]
    assert len(distances) > 4 and distances == sorted(distances)
    assert len(made.at_error(distances[2] * 1.001).vertices) <= made.proved[2][0]
    with pytest.raises(nm.NeuralMeshError, match="no level has a proved distance"):
        nm.progression(mesh).at_error(0.1)


def test_wrong_options_are_refused() -> None:
    mesh = torus(20, 10)
    with pytest.raises(nm.OptionError, match="no such option: faces"):
        nm.progression(mesh, faces=10)
    with pytest.raises(nm.OptionError, match="give out to at_faces"):
        nm.progression(mesh, out="light.ply")

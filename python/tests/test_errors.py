"""Every error is one clear line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import torus

MESH = torus(20, 12)


@pytest.mark.parametrize(
    ("mesh", "options", "says"),
    [
        (MESH, {}, "no size: give exactly one of ratio, vertices, faces, error, size"),
        (MESH, {"ratio": 0.5, "faces": 10}, "ratio and faces: give exactly one"),
        (MESH, {"ratio": 2.0}, "ratio=2: give a share above 0 and at most 1"),
        (MESH, {"ratio": float("nan")}, "give a share above 0"),
        (MESH, {"ratio": -0.5}, "ratio=-0.5: give a share above 0"),
        (MESH, {"ratio": 50}, "did you mean 50%?"),
        (MESH, {"vertices": -5}, "vertices=-5: give a whole number above 0, like 5000, 10k or 1.5M"),
        (MESH, {"error": "-1%"}, "error=-1%: give a distance"),
        (MESH, {"ratio": 0.5, "importance": "force"}, "importance=force: the mesh has no such attribute"),
        (MESH, {"ratio": 0.5, "weights": "-f"}, "-f: "),
        (MESH, {"error": "much"}, "error=much: give a distance"),
        (MESH, {"ratio": 0.5, "assembly": "paper", "keep_components": True}, "keep_components=True: not available with assembly=paper"),
        (MESH, {"ratio": 0.5, "threads": 0}, "give a number from 1"),
        (MESH, {"ratio": 0.5, "optimize": "speed"}, "optimize=speed: choose from balanced, mean"),
        (MESH, {"ratio": 0.5, "importance": np.zeros(240)}, "give numbers of at least 0, with one above 0"),
        (MESH, {"ratio": 0.5, "attributes": {"uv": np.zeros((7, 2))}}, "uv: an array of shape (7, 2)"),
        (MESH, {"ratio": 0.5, "groups": np.zeros(3)}, "groups: an array of shape (3,)"),
        (MESH, {"ratio": 0.5, "weights": "nowhere.safetensors"}, "nowhere.safetensors"),
        ((MESH[0], MESH[1][:0]), {"ratio": 0.5}, "no faces"),
        ((MESH[0][:, :2], MESH[1]), {"ratio": 0.5}, "vertices: an array of shape (240, 2): give n x 3"),
        ((MESH[0], MESH[1][:, :2]), {"ratio": 0.5}, "give triangles"),
        ((MESH[0], MESH[1].astype(float)), {"ratio": 0.5}, "give whole numbers"),
        ((MESH[0] * np.nan, MESH[1]), {"ratio": 0.5}, "no usable face"),
        ((MESH[0], MESH[1] + 1000), {"ratio": 0.5}, "corners out of range"),
        ((MESH[0], MESH[1] - 1000), {"ratio": 0.5}, "corners out of range"),
        (42, {"ratio": 0.5}, "int: not a mesh: give a file"),
        ("nowhere.ply", {"ratio": 0.5}, "nowhere.ply"),
        ("-", {"ratio": 0.5}, "./-"),
        (MESH, {"ratio": 0.5, "out": "x.nothing"}, "the format is not known"),
        (MESH, {"ratio": 0.5, "out": "nowhere/x.ply"}, "there is no folder"),
        (MESH, {"ratio": 0.5, "keep_feature": True}, "simplify: no such option: keep_feature; did you mean keep_features?"),
        (MESH, {"ratio": 0.5, "xyzzy": True}, "simplify: no such option: xyzzy: choose from ratio, vertices"),
        (MESH, {"error": 500}, "error=500: is more than half of the diagonal"),
        (MESH, {"error": 50}, "did you mean 50%?"),
        (MESH, {"ratio": 0.5, "bake": 512}, "bake: this wheel lacks the feature bake: build a wheel"),
        ((np.ma.masked_array(MESH[0], MESH[0] > 1.5), MESH[1]), {"ratio": 0.5}, "a masked array: give a plain one"),
        (MESH, {"ratio": 0.5, "attributes": {"uv": np.ma.masked_array(np.zeros((240, 2)), True)}}, "a masked array"),
    ],
)
def test_errors_are_one_line(mesh: Any, options: dict[str, Any], says: str) -> None:
    with pytest.raises(nm.NeuralMeshError) as caught:
        nm.simplify(mesh, **options)
    text = str(caught.value)
    assert says in text and "\n" not in text and "--" not in text


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"faces": 10**400}, "a whole number is too large"),
        ({"ratio": 0.5, "seed": 2**70}, "a whole number is too large"),
        ({"faces": 1e300}, "give a whole number above 0"),
        ({"ratio": 0.5, "keep": "wheel"}, "keep=wheel: give a list"),
        ({"ratio": 0.5, "ratio_of": {1: 0.5}}, "1: give names as text"),
        ({"ratio": 0.5, "attributes": {1: np.zeros(240)}}, "with text for names"),
        ({"ratio": 0.5, "attributes": np.zeros(240)}, "attributes: give arrays by name"),
        ({"ratio": 0.5, "lock_boundaries": "yes"}, "lock_boundaries=yes: give true or false"),
        ({"ratio": 0.5, "seed": -1}, "seed=-1: give a whole number of at least 0"),
    ],
)
def test_wrong_values_are_option_errors(options: dict[str, Any], says: str) -> None:
    with pytest.raises(nm.OptionError) as caught:
        nm.simplify(MESH, **options)
    text = str(caught.value)
    assert says in text and len(text) < 200 and "--" not in text


def test_unaligned_arrays_are_copied() -> None:
    buffer = np.zeros(1 + 12 * len(MESH[0]) + 4, np.uint8)
    vertices = buffer[1 : 1 + 12 * len(MESH[0])].view(np.float32).reshape(-1, 3)
    vertices[:] = MESH[0]
    assert not vertices.flags.aligned
    rows = np.zeros(len(MESH[0]), np.dtype([("kind", "u1"), ("at", "<f4", 3)]))
    rows["at"] = MESH[0]
    expected = nm.simplify((MESH[0].astype(np.float32), MESH[1]), ratio=0.5)
    for given in (vertices, rows["at"]):
        light = nm.simplify((given, MESH[1]), ratio=0.5, attributes={"height": given[:, 2]})
        assert len(light.faces) == len(expected.faces)


def test_a_mesh_of_meshio_is_read_or_refused() -> None:
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(MESH[0], [("triangle", MESH[1])], point_data={"height": MESH[0][:, 2]})
    light = nm.simplify(mesh, ratio=0.5).mesh
    assert isinstance(light, meshio.Mesh) and len(light.point_data["height"]) == len(light.points) == 120
    with pytest.raises(nm.NeuralMeshError, match="meshio.Mesh: its cells are tetra"):
        nm.simplify(meshio.Mesh(MESH[0], [("tetra", np.zeros((1, 4), int))]), ratio=0.5)


def test_errors_are_value_errors_and_option_errors() -> None:
    assert issubclass(nm.NeuralMeshError, ValueError) and issubclass(nm.OptionError, nm.NeuralMeshError)
    with pytest.raises(nm.OptionError):
        nm.simplify(MESH, ratio=7.0)
    with pytest.raises(nm.NeuralMeshError) as caught:
        nm.simplify((MESH[0], MESH[1][:0]), ratio=0.5)
    assert not isinstance(caught.value, nm.OptionError)


def test_lods_reject_other_sizes() -> None:
    with pytest.raises(nm.OptionError, match="no such option: faces"):
        nm.lods(MESH, [0.5, 0.1], faces=3)
    with pytest.raises(nm.OptionError, match="lods: give falling shares"):
        nm.lods(MESH, [0.1, 0.5])

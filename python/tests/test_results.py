"""Results: as input, in memory and as files; names, warnings, face values, and the report."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neural_mesh as nm
from conftest import grid, torus


def test_two_arrays_equal_a_pair() -> None:
    vertices, faces = torus(30, 20)
    np.testing.assert_array_equal(nm.simplify(vertices, faces, ratio=0.3).vertices, nm.simplify((vertices, faces), ratio=0.3).vertices)


def test_vertex_attributes_survive_repeated_calls() -> None:
    vertices, faces = torus(40, 30)
    light = nm.simplify(vertices, faces, ratio=0.5, attributes={"heat": vertices[:, 0].astype(np.float64)})
    again = nm.simplify(light, ratio=0.5)
    assert again.attributes["heat"].ndim == 1 and again.attributes["heat"].dtype == np.float64
    assert np.abs(again.corners("heat") - again.vertices[again.faces][..., 0]).max() < 0.1
    assert nm.compare((vertices, faces), light)["distance_mean"] is not None
    assert nm.show((vertices, faces), light).page is not None


@pytest.mark.parametrize("format", ["ply", "obj", "glb", "stl", "off"])
def test_results_are_saved_and_read_back(format: str, tmp_path: Path) -> None:
    light = nm.simplify(torus(40, 30), ratio=0.2)
    said = light.to_bytes(format)
    path = light.save(tmp_path / f"light.{format}")
    assert Path(path).read_bytes() == said
    with pytest.raises(nm.NeuralMeshError, match="exists already"):
        light.save(path)
    for again in (nm.simplify(path, ratio=1.0), nm.simplify(io.BytesIO(said), ratio=1.0), nm.simplify(memoryview(said), ratio=1.0)):
        assert len(again.faces) == len(light.faces) and len(again.vertices) == len(light.vertices)
    with open(path, "rb") as file:
        assert len(nm.simplify(file, ratio=0.5).vertices) == len(light.vertices) // 2


def test_attribute_names_are_independent_of_format(tmp_path: Path) -> None:
    vertices, faces, uv = grid(20)
    normals = np.tile([0.0, 0.0, 1.0], (len(vertices), 1))
    colours = np.full((len(vertices), 3), 0.5)
    light = nm.simplify(vertices, faces, ratio=0.5, attributes={"uv": uv, "normals": normals, "colors": colours})
    for format in ("ply", "obj", "glb"):
        again = nm.simplify(light.to_bytes(format), ratio=1.0)
        assert set(again.attributes) == {"uv", "normals", "colors"}, format


def test_missed_size_warns() -> None:
    with pytest.warns(nm.NeuralMeshWarning, match="stopped: "):
        light = nm.simplify(torus(20, 12), faces=4)
    assert not light.reached
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert nm.simplify(torus(20, 12), ratio=0.5).reached


@pytest.mark.parametrize(
    ("dirt", "says"),
    [("nan", "1 faces|6 faces with coordinates"), ("range", "1 faces with indices out of range"), ("one", "indices begin at 1: subtract 1")],
)
def test_cleaned_input_warns_or_raises(dirt: str, says: str) -> None:
    vertices, faces = torus(20, 12, np.float64)
    if dirt == "nan":
        vertices[7] = np.nan
    elif dirt == "range":
        faces[3, 1] = len(vertices) + 5
    else:
        faces = faces + 1
    with pytest.warns(nm.NeuralMeshWarning, match=says):
        light = nm.simplify(vertices, faces, ratio=0.5)
    assert light.cleaned
    with pytest.raises(nm.NeuralMeshError, match=says.replace("were left out", "are in the mesh")):
        nm.simplify(vertices, faces, ratio=0.5, on_dirty="raise")
    with warnings.catch_warnings():
        warnings.simplefilter("error", nm.NeuralMeshWarning)
        nm.simplify(vertices, faces, ratio=0.5, on_dirty="ignore")
    with pytest.raises(nm.OptionError, match="choose from warn, raise, ignore"):
        nm.simplify(vertices, faces, ratio=0.5, on_dirty="explode")  # type: ignore[call-overload]


def test_rejected_file_writes_nothing(tmp_path: Path) -> None:
    source, out = tmp_path / "broken.obj", tmp_path / "light.obj"
    source.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 9\n")
    with pytest.raises(nm.NeuralMeshError, match="indices out of range are in the mesh"):
        nm.simplify(source, ratio=1.0, out=out, on_dirty="raise")
    assert not out.exists()
    with pytest.warns(nm.NeuralMeshWarning, match="indices out of range"):
        nm.simplify(source, ratio=1.0, out=out)
    assert out.exists()


def test_numpy_options_and_wrong_options() -> None:
    mesh = torus(20, 12)
    expected = nm.simplify(mesh, ratio=0.5, threads=1)
    said: dict[str, Any] = {"ratio": np.float32(0.5), "threads": np.int64(1), "lock_boundaries": np.False_, "map": np.array(False)}
    light = nm.simplify(mesh, **said)
    np.testing.assert_array_equal(light.vertices, expected.vertices)
    assert light.map is None
    for threads in (-1, 0, True, 1.5, "2"):
        with pytest.raises(nm.OptionError, match="threads"):
            nm.simplify(mesh, ratio=0.5, threads=threads)  # type: ignore[call-overload]
    with pytest.raises(nm.OptionError, match="no such option: ration"):
        nm.simplify(mesh, ration=0.5)  # type: ignore[call-overload]
    with pytest.raises(nm.OptionError, match="give a list"):
        nm.lods(mesh, 0.5)  # type: ignore[call-overload]
    assert issubclass(nm.OptionError, nm.NeuralMeshError) and issubclass(nm.NotReachedError, nm.NeuralMeshError)


def test_many_meshes_keep_order() -> None:
    meshes = [torus(20 + 4 * i, 12) for i in range(6)]
    lights = nm.simplify_many(meshes, ratio=0.5, threads=2)
    assert [len(light.vertices) for light in lights] == [len(vertices) // 2 for vertices, _ in meshes]
    np.testing.assert_array_equal(lights[3].vertices, nm.simplify(meshes[3], ratio=0.5).vertices)
    with pytest.raises(nm.NeuralMeshError):
        nm.simplify_many([meshes[0], (np.zeros((0, 3)), np.zeros((0, 3), int))], ratio=0.5)


def test_report_matches_schema(tmp_path: Path) -> None:
    schema = nm.report_schema()
    vertices, faces, uv = grid(12)
    runs = [nm.simplify(torus(20, 12), ratio=0.5), nm.simplify(torus(20, 12), error="1%"), nm.simplify(vertices, faces, faces=100, check=True)]
    runs += nm.lods(torus(20, 12), [0.5, 0.2], check=True)
    source = tmp_path / "source.obj"
    nm.simplify(torus(20, 12), ratio=1.0, out=source)
    runs.append(nm.simplify(source, ratio=0.5, out=tmp_path / "light.obj", picture=tmp_path / "light.png"))
    assert runs[-1].report["seconds"]["picture"] > 0.0
    for light in runs:
        assert not list(find_mismatches(light.report, schema)), light.report


def find_mismatches(value: Any, schema: dict[str, Any], at: str = "report") -> Any:
    """Yields the places where a value violates a JSON schema."""
    if "anyOf" in schema:
        if all(list(find_mismatches(value, each, at)) for each in schema["anyOf"]):
            yield at
        return
    kinds = {"integer": int, "number": (int, float), "string": str, "boolean": bool, "null": type(None), "object": dict, "array": list}
    if "type" in schema and not isinstance(value, kinds[schema["type"]]):
        yield at
    elif schema.get("type") == "array":
        for item in value:
            yield from find_mismatches(item, schema["items"], f"{at}[]")
    elif schema.get("type") == "object":
        more = schema["additionalProperties"]
        yield from (f"{at}.{name}" for name in schema.get("required", ()) if name not in value)
        for name, item in value.items():
            known = schema.get("properties", {}).get(name, more)
            if known is False:
                yield f"{at}.{name}"
            else:
                yield from find_mismatches(item, known, f"{at}.{name}")


def test_scene_arrays_are_in_world_coordinates(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.icosphere(4), node_name="ball")
    scene.add_geometry(trimesh.creation.icosphere(3), node_name="far", transform=trimesh.transformations.translation_matrix([5, 0, 0]))
    light = nm.simplify(scene, ratio=0.3)
    assert isinstance(light.mesh, trimesh.Scene) and len(light.mesh.geometry) == 2
    n_faces = sum(len(mesh.faces) for mesh in light.mesh.geometry.values())
    assert len(light.faces) == n_faces and light.vertices[:, 0].max() > 5.5
    out = tmp_path / "light.glb"
    light = nm.simplify(scene, ratio=0.3, out=out)
    assert out.exists() and isinstance(light.mesh, trimesh.Scene) and len(light.faces) == n_faces


def test_face_values_are_carried_without_constraint() -> None:
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = torus(60, 40)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.face_attributes["side"] = np.where(vertices[faces].mean(1)[:, 0] > 0, 1.5, -2.5)
    # As groups, one number per face would keep every face.
    mesh.face_attributes["number"] = np.arange(len(faces))
    light = nm.simplify(mesh, ratio=0.1)
    assert len(light.faces) == len(faces) // 10 and light.groups is None
    assert set(light.face_attributes) == {"side", "number"} == set(light.mesh.face_attributes)
    side = np.where(light.vertices[light.faces].mean(1)[:, 0] > 0, 1.5, -2.5)
    assert (side == light.face_attributes["side"]).mean() > 0.95
    near = vertices[faces[light.face_attributes["number"]]].mean(1) - light.vertices[light.faces].mean(1)
    assert np.abs(near).max() < 0.3
    named = nm.simplify(mesh, ratio=0.3, groups="side")
    assert named.groups is not None and set(named.groups) == {1.5, -2.5} and set(named.face_attributes) == {"number"}
    with pytest.raises(nm.OptionError, match="choose from side, number"):
        nm.simplify(mesh, ratio=0.3, groups="sides")


def test_face_values_of_cleaned_mesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = torus(30, 20)
    dirty = np.concatenate([[[0, 0, 1]], faces[:5], faces])
    mesh = trimesh.Trimesh(vertices, dirty, process=False)
    mesh.face_attributes["number"] = np.arange(len(dirty))
    light = nm.simplify(mesh, ratio=0.5)
    near = vertices[dirty[light.face_attributes["number"]]].mean(1) - light.vertices[light.faces].mean(1)
    assert np.abs(near).max() < 0.3


def test_clean_faces_match_map() -> None:
    vertices, faces = torus(30, 20)
    dirty = np.concatenate([[[0, 0, 1]], faces[:5], faces])
    for weld in (True, False):
        light = nm.simplify((vertices, dirty), ratio=0.5, weld=weld, map=True)
        clean = nm.find_clean_faces(vertices, dirty, light.report["input"]["faces"], weld)
        assert clean is not None and clean.tolist() == [*range(1, 6), *range(11, len(dirty))] and light.map is not None
        points = (vertices[dirty[clean][light.map.corner_faces]] * light.map.corner_weights[..., None]).sum(2)
        assert np.abs(points - light.vertices[light.faces]).max() < 0.1
    assert nm.find_clean_faces(vertices, dirty, 3) is None


def test_pyvista_cell_data() -> None:
    pv = pytest.importorskip("pyvista")
    mesh = pv.PolyData.from_regular_faces(*torus(60, 40))
    mesh.cell_data["vtkOriginalCellIds"] = np.arange(mesh.n_cells)
    mesh.cell_data["heat"] = np.linspace(0, 1, mesh.n_cells)
    light = nm.simplify(mesh, ratio=0.1)
    assert light.mesh.n_cells == 480 and set(light.mesh.cell_data.keys()) == {"vtkOriginalCellIds", "heat"}
    assert light.mesh.cell_data["heat"].dtype == mesh.cell_data["heat"].dtype
    mesh.cell_data["MaterialIds"] = (mesh.cell_centers().points[:, 0] > 0).astype(np.int64)
    assert set(nm.simplify(mesh, ratio=0.2).mesh.cell_data["MaterialIds"]) == {0, 1}
    free = nm.simplify(mesh, ratio=0.2, groups=None)
    assert free.groups is None and "MaterialIds" in free.mesh.cell_data


def test_open3d_tensors_keep_material() -> None:
    o3d = pytest.importorskip("open3d")
    mesh = o3d.t.geometry.TriangleMesh.create_torus(1.0, 0.4, 60, 40)
    mesh.material.set_default_properties()
    mesh.material.material_name = "defaultLit"
    mesh.material.scalar_properties["roughness"] = 0.25
    mesh.vertex["heat"] = o3d.core.Tensor(np.arange(len(mesh.vertex.positions), dtype=np.float32)[:, None])
    mesh.triangle["part"] = o3d.core.Tensor(np.arange(len(mesh.triangle.indices), dtype=np.int64)[:, None])
    light = nm.simplify(mesh, ratio=0.2).mesh
    assert isinstance(light, o3d.t.geometry.TriangleMesh) and "heat" in light.vertex and "part" in light.triangle
    assert light.material.material_name == "defaultLit" and light.material.scalar_properties["roughness"] == 0.25


def test_collapses_number_points_like_replay() -> None:
    from neural_mesh.compat.fast_simplification import simplify

    vertices, faces = torus(40, 30, np.float64)
    points, triangles, collapses = simplify(vertices, faces, 0.8, return_collapses=True)
    stays = np.ones(len(vertices), bool)
    stays[collapses[:, 1]] = False
    into = np.arange(len(vertices))
    into[collapses[:, 1]] = collapses[:, 0]
    number = (np.cumsum(stays) - 1)[into]
    assert stays.sum() == len(points) and triangles.max() < len(points)
    # Each input point is close to the one that its collapse names.
    assert np.linalg.norm(points[number] - vertices, axis=1).mean() < 0.15
    # Without collapses the points are placed nearer; the triangles are the same.
    fitted, same = simplify(vertices, faces, 0.8)
    rotated = [{tuple(np.roll(face, -int(face.argmin()))) for face in each} for each in (triangles, same)]
    assert rotated[0] == rotated[1] and np.linalg.norm(fitted - points, axis=1).mean() < 0.05
    assert len(simplify(vertices, faces, 0.8, agg=0)[1]) == len(faces)

"""Compares textured results with those of open3d, pymeshlab, trimesh and meshlib. `python -P python/measure_textures.py MESH.obj... [--ratio R]`.

It prints for each result: the share of the surface whose texture moved by at most eight texels (1024 a side); the mean distance, both
ways, relative to this package; and the number of edges that do not have two faces, with corners at equal positions counted as one.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import neural_mesh as nm

N_SAMPLES = 30_000
NEAR = 8 / 1024

Textured = tuple[Any, Any]
"""Corners of faces, n x 3 x 3, and their texture coordinates, n x 3 x 2."""


def read(path: Path) -> Textured:
    """Reads the triangles of an OBJ file; polygons become fans."""
    places: list[list[float]] = []
    coordinates: list[list[float]] = []
    corners: list[list[tuple[int, int]]] = []
    for line in path.read_text(errors="replace").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            places.append([float(word) for word in words[:3]])
        elif kind == "vt":
            coordinates.append([float(word) for word in words[:2]])
        elif kind == "f":
            around = [(int(word.split("/")[0]) - 1, int(word.split("/")[1]) - 1) for word in words]
            corners += [[around[0], p, q] for p, q in zip(around[1:], around[2:])]
    index = np.array(corners)
    return np.array(places)[index[..., 0]], np.array(coordinates)[index[..., 1]]


def neural_mesh(path: Path, n: int) -> Textured:
    with tempfile.TemporaryDirectory() as folder:
        nm.simplify(path, faces=n, out=Path(folder) / "light.obj")
        return read(Path(folder) / "light.obj")


def pymeshlab(path: Path, n: int) -> Textured:
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    if not meshes.current_mesh().has_wedge_tex_coord():
        meshes.compute_texcoord_transfer_vertex_to_wedge()
    meshes.meshing_decimation_quadric_edge_collapse_with_texture(targetfacenum=n)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix()[mesh.face_matrix()], mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)


def meshlib(path: Path, n: int) -> Textured:
    from meshlib import mrmeshnumpy, mrmeshpy

    loading = mrmeshpy.MeshLoadSettings()
    loading.uvCoords = coordinates = mrmeshpy.VertCoords2()
    data = mrmeshpy.ObjectMeshData()
    data.mesh, data.uvCoordinates = mrmeshpy.loadMesh(str(path), loading), coordinates
    settings = mrmeshpy.DecimateSettings()
    settings.maxDeletedFaces = data.mesh.topology.numValidFaces() - n
    settings.maxError = 1e30
    settings.packMesh = True
    mrmeshpy.decimateObjectMeshData(data, settings)
    places, faces = mrmeshnumpy.getNumpyVerts(data.mesh), mrmeshnumpy.getNumpyFaces(data.mesh.topology)
    of_vertices = [data.uvCoordinates[mrmeshpy.VertId(v)] for v in range(len(places))]
    return places[faces], np.array([[uv.x, uv.y] for uv in of_vertices])[faces]


def open3d(path: Path, n: int) -> Textured | None:
    import open3d as o3d

    light = o3d.io.read_triangle_mesh(str(path)).simplify_quadric_decimation(n)
    if len(light.triangle_uvs) != 3 * len(light.triangles):
        return None
    return np.asarray(light.vertices)[np.asarray(light.triangles)], np.asarray(light.triangle_uvs).reshape(-1, 3, 2)


def trimesh(path: Path, n: int) -> Textured | None:
    import trimesh

    light = trimesh.load(path, process=False).simplify_quadric_decimation(face_count=n)
    uv = getattr(light.visual, "uv", None)
    return None if uv is None else (light.vertices[light.faces], uv[light.faces])


METHODS: dict[str, Callable[[Path, int], Textured | None]] = {
    "neural-mesh": neural_mesh,
    "PyMeshLab": pymeshlab,
    "meshlib": meshlib,
    "Open3D": open3d,
    "trimesh": trimesh,
}


class Surface:
    """A textured triangle soup for sampling and closest-point queries."""

    def __init__(self, triangles: Any, coordinates: Any) -> None:
        import open3d as o3d

        self.triangles, self.coordinates = triangles, coordinates
        self.scene = o3d.t.geometry.RaycastingScene()
        corners = np.asarray(triangles, np.float32).reshape(-1, 3)
        self.scene.add_triangles(corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3))

    def sample(self) -> tuple[Any, Any]:
        """Returns points drawn uniformly by area, n x 3, and their texture coordinates, n x 2."""
        rng = np.random.default_rng(0)
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        faces = rng.choice(len(areas), N_SAMPLES, p=areas / areas.sum())
        weights = rng.dirichlet([1.0, 1.0, 1.0], N_SAMPLES)[:, :, None]
        return (weights * self.triangles[faces]).sum(1), (weights * self.coordinates[faces]).sum(1)

    def distance(self, points: Any) -> float:
        return float(self.scene.compute_distance(np.asarray(points, np.float32)).numpy().mean())

    def texture_at(self, points: Any) -> Any:
        """Returns the texture coordinates at the closest points of the surface, n x 2."""
        nearest = self.scene.compute_closest_points(np.asarray(points, np.float32))
        uv = nearest["primitive_uvs"].numpy()
        weights = np.c_[1 - uv.sum(1), uv][:, :, None]
        return (weights * self.coordinates[nearest["primitive_ids"].numpy()]).sum(1)


def count_unpaired_edges(triangles: Any) -> int:
    """Counts the edges that do not have two faces."""
    _, corners = np.unique(np.asarray(triangles, np.float32).reshape(-1, 3), axis=0, return_inverse=True)
    faces = corners.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return int((np.unique(edges, axis=0, return_counts=True)[1] != 2).sum())


def measure_result(original: Surface, result: Textured | None) -> tuple[float, float, int] | None:
    """Returns the share of the surface with the texture in place, the mean distance, and the unpaired edges; `None` without texture."""
    if result is None:
        return None
    light = Surface(*result)
    points, texture = light.sample()
    near = np.linalg.norm(texture - original.texture_at(points), axis=1) <= NEAR
    return float(near.mean()), original.distance(points) + light.distance(original.sample()[0]), count_unpaired_edges(result[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--ratio", type=float, default=0.1)
    args = parser.parse_args()
    rows = []
    for path in args.meshes:
        original = read(path)
        n = int(args.ratio * len(original[0]))
        rows.append({name: measure_result(Surface(*original), method(path, n)) for name, method in METHODS.items()})
    for name in METHODS:
        found = [(row[name], row["neural-mesh"]) for row in rows]
        both = [(theirs, our) for theirs, our in found if theirs is not None and our is not None]
        if not both:
            print(name, "loses the texture")
            continue
        near = statistics.median(theirs[0] for theirs, _ in both)
        distance = statistics.median(theirs[1] / our[1] for theirs, our in both)
        opened = sum(theirs[2] > our[2] for theirs, our in both)
        print(f"{name}: texture near {near:.3f}, distance {distance:.2f}, more open edges than neural-mesh {opened} of {len(both)}")


if __name__ == "__main__":
    main()

"""Compares the package with others on one core: time, distance, holes. `python -P python/measure.py MESHES [--most-faces N] [--ratio R]`.

Every package simplifies each mesh of a folder to one number of faces, three times in turns; the median time counts. Times and distances
are printed relative to fast_simplification, as medians over the meshes. A result has holes if the input is closed and some of its edges
do not have two faces. Run it on an idle machine; `taskset -c 0` limits all packages to one core.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import neural_mesh as nm

Pair = tuple[Any, Any]


def neural_mesh(vertices: Any, faces: Any, n: int) -> Pair:
    v, f = nm.simplify((vertices, faces), faces=n, threads=1)
    return v, f


def fast_simplification(vertices: Any, faces: Any, n: int) -> Pair:
    import fast_simplification

    v, f = fast_simplification.simplify(vertices, faces, target_count=n)
    return v, f


def pyfqmr(vertices: Any, faces: Any, n: int) -> Pair:
    import pyfqmr

    mesh = pyfqmr.Simplify()
    mesh.setMesh(vertices, faces)
    mesh.simplify_mesh(target_count=n, preserve_border=False, verbose=False)
    v, f, _ = mesh.getMesh()
    return v, f


def pymeshlab(vertices: Any, faces: Any, n: int) -> Pair:
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()


def open3d(vertices: Any, faces: Any, n: int) -> Pair:
    import open3d as o3d

    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    light = mesh.simplify_quadric_decimation(n)
    return np.asarray(light.vertices), np.asarray(light.triangles)


def trimesh(vertices: Any, faces: Any, n: int) -> Pair:
    import trimesh

    light = trimesh.Trimesh(vertices, faces, process=False).simplify_quadric_decimation(face_count=n)
    return np.asarray(light.vertices), np.asarray(light.faces)


def meshlib(vertices: Any, faces: Any, n: int) -> Pair:
    from meshlib import mrmeshnumpy, mrmeshpy

    mesh = mrmeshnumpy.meshFromFacesVerts(faces, vertices)
    settings = mrmeshpy.DecimateSettings()
    settings.maxDeletedFaces = len(faces) - n
    settings.maxError = 1e30
    settings.packMesh = True
    mrmeshpy.decimateMesh(mesh, settings)
    return mrmeshnumpy.getNumpyVerts(mesh), mrmeshnumpy.getNumpyFaces(mesh.topology)


METHODS: dict[str, Callable[[Any, Any, int], Pair]] = {
    "neural-mesh": neural_mesh,
    "fast_simplification": fast_simplification,
    "pyfqmr": pyfqmr,
    "PyMeshLab": pymeshlab,
    "Open3D": open3d,
    "trimesh": trimesh,
    "meshlib": meshlib,
}


def count_unpaired_edges(faces: Any) -> int:
    """Counts the edges that do not have two faces."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64), axis=1)
    return int((np.unique(edges, axis=0, return_counts=True)[1] != 2).sum())


def measure_mesh(path: Path, ratio: float, most_faces: int) -> dict[str, Any] | None:
    """Returns by package: seconds, mean distance, whether a closed mesh got holes, whether it was closed, and faces over those requested."""
    original = nm.simplify(path, ratio=1.0, scores="geometry")
    vertices, faces = np.ascontiguousarray(original.vertices, np.float64), np.ascontiguousarray(original.faces, np.int32)
    if len(faces) > most_faces:
        return None
    n, is_closed, rows = int(ratio * len(faces)), count_unpaired_edges(faces) == 0, {}
    seconds: dict[str, list[float]] = {name: [] for name in METHODS}
    for _ in range(3):
        for name, method in METHODS.items():
            began = time.perf_counter()
            result = method(vertices, faces, n)
            seconds[name].append(time.perf_counter() - began)
            rows[name] = result
    found = {}
    for name, (v, f) in rows.items():
        f = np.asarray(f)
        distance = nm.compare((vertices, faces), (np.asarray(v, np.float64), f), samples=20_000)["distance_mean"]
        holes = is_closed and count_unpaired_edges(f) > 0
        found[name] = (statistics.median(seconds[name]), distance, holes, is_closed, len(f) / n)
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("meshes", type=Path)
    parser.add_argument("--ratio", type=float, default=0.1)
    parser.add_argument("--most-faces", type=int, default=10**9)
    args = parser.parse_args()
    found = {}
    for path in sorted(args.meshes.rglob("*.ply")):
        # `None` for a mesh with more faces than requested.
        row = measure_mesh(path, args.ratio, args.most_faces)
        if row is not None:
            found[path.stem] = row
            print(path.stem, {name: f"{of[0]:.3f} s, {of[1]:.4f} %" for name, of in row.items()}, flush=True)
    print(f"\n{len(found)} meshes\n\n| package | time | mean distance | closed meshes that got holes | faces over those asked for |\n|---|---|---|---|---|")
    for name in METHODS:
        quotient = lambda at: statistics.median(row[name][at] / row["fast_simplification"][at] for row in found.values())  # noqa: E731
        holes = sum(row[name][2] for row in found.values())
        closed = sum(row[name][3] for row in found.values())
        faces = statistics.median(row[name][4] for row in found.values())
        print(f"| {name} | {quotient(0):.2f} | {quotient(1):.2f} | {holes} of {closed} | {faces:.2f} |")


if __name__ == "__main__":
    main()

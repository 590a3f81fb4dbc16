#!/usr/bin/env python3
"""Makes meshes of about 10, 30, 100, 300 and 1000 thousand faces of one mesh, to time methods against size.

    scripts/sized_meshes.py MESH OUT_DIR

The mesh is subdivided (Loop 1987) until it is finer than the finest one, and made lighter from there by Open3D's quadric
decimation, so that every size is an irregular mesh of the same surface. Needs `pip install open3d`; no part of the build or
of its tests.
"""

import pathlib
import sys

import open3d as o3d

FACES = [10_000, 30_000, 100_000, 300_000, 1_000_000]


def finer(mesh):
    """The mesh subdivided until it has more faces than the finest one asked for."""
    while len(mesh.triangles) <= FACES[-1]:
        mesh = mesh.subdivide_loop(number_of_iterations=1)
    return mesh


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: scripts/sized_meshes.py MESH OUT_DIR")
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    mesh = o3d.io.read_triangle_mesh(sys.argv[1])
    fine = finer(mesh.remove_duplicated_vertices())
    for n_faces in FACES:
        lighter = fine.simplify_quadric_decimation(target_number_of_triangles=n_faces).remove_unreferenced_vertices()
        path = folder / f"faces-{n_faces:07}.ply"
        o3d.io.write_triangle_mesh(str(path), lighter, write_vertex_normals=False)
        print(path, len(lighter.triangles))


if __name__ == "__main__":
    main()

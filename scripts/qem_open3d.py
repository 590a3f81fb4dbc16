#!/usr/bin/env python3
"""Simplifies meshes by Garland and Heckbert's QEM with optimal placement, as Open3D has it, for `compare paper`.

    scripts/qem_open3d.py OUT_DIR RATIO[,RATIO...] MESH...

Writes OUT_DIR/NAME-RATIO.ply for each mesh and ratio, and OUT_DIR/times.csv with the columns mesh, ratio, seconds. What is
there already is not made again. Needs `pip install open3d`; no part of the build or of its tests.

Open3D takes a number of faces. Asked for is the input's number times the ratio of vertices: on surfaces that are closed, or
nearly so, there are two faces for each vertex before and after, so the vertices come to the ratio as well. Unused vertices of
the input are left out first, and time is that of the simplification alone.
"""

import csv
import pathlib
import sys
import time

import open3d as o3d


def simplified(mesh, ratio):
    """The lighter mesh and the seconds it took."""
    n_faces = round(len(mesh.triangles) * ratio)
    start = time.perf_counter()
    lighter = mesh.simplify_quadric_decimation(target_number_of_triangles=n_faces)
    seconds = time.perf_counter() - start
    return lighter.remove_unreferenced_vertices(), seconds


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__.strip().splitlines()[2].strip())
    out = pathlib.Path(sys.argv[1])
    ratios = sys.argv[2].split(",")
    out.mkdir(parents=True, exist_ok=True)
    times = out / "times.csv"
    if not times.exists():
        times.write_text("mesh,ratio,seconds\n")
    for path in map(pathlib.Path, sys.argv[3:]):
        todo = [ratio for ratio in ratios if not (out / f"{path.stem}-{ratio}.ply").exists()]
        if not todo:
            continue
        mesh = o3d.io.read_triangle_mesh(str(path)).remove_unreferenced_vertices()
        for ratio in todo:
            lighter, seconds = simplified(mesh, float(ratio))
            o3d.io.write_triangle_mesh(str(out / f"{path.stem}-{ratio}.ply"), lighter)
            with times.open("a", newline="") as file:
                csv.writer(file).writerow([path.stem, ratio, f"{seconds:.6f}"])


if __name__ == "__main__":
    main()

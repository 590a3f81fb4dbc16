#!/usr/bin/env python3
"""Compares the figures of `examples/measure.rs` with those of other tools and prints Markdown tables; see `scripts/agreement`.

    scripts/agreement.py FOLDER...

Needs `pip install numpy scipy pymeshlab robust_laplacian potpourri3d libigl`. Each figure is the difference as a share of
the other tool's value (of the largest value, for distances along the surface).
"""

import json
import sys
from pathlib import Path

import igl.copyleft.cgal
import numpy as np
import potpourri3d
import pymeshlab
import robust_laplacian
import scipy.sparse.linalg

# Largest number of vertices for a dense inverse; above, eigenpairs of scipy are used, as the inverse takes too long.
DENSE = 3000


def mesh(path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


def distance(samples, target):
    """Returns mean, root mean square and largest distance of samples to a surface, by PyMeshLab."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.array(samples)))
    meshes.add_mesh(pymeshlab.Mesh(*target))
    found = meshes.get_hausdorff_distance(
        sampledmesh=0, targetmesh=1, samplevert=True, sampleedge=False, sampleface=False,
        samplenum=len(samples), maxdist=pymeshlab.PercentageValue(100),
    )
    assert found["n_samples"] == len(samples)
    return np.array([found["mean"], found["RMS"], found["max"]])


def eigenpairs(laplacian, mass, n_pairs):
    """Returns the lowest eigenpairs by scipy."""
    shift = -1e-2 / mass.diagonal().sum()
    return scipy.sparse.linalg.eigsh(laplacian.tocsc(), n_pairs, mass.tocsc(), sigma=shift)


def biharmonic(laplacian, mass, values, functions):
    """Returns biharmonic distances from vertex 0, by a dense inverse of the squared operator, or by eigenpairs for many vertices."""
    m = mass.diagonal()
    if len(m) <= DENSE:
        inverse = np.linalg.inv(laplacian.toarray() + np.outer(m, m) / m.sum())
        green = inverse @ (m[:, None] * inverse)
        squares = np.diag(green) + green[0, 0] - 2 * green[0]
        return np.sqrt(np.maximum(squares, 0)), "all pairs"
    used = values > 1e-6 * values[-1] / len(values)
    scaled = functions[:, used] / values[used]
    return np.linalg.norm(scaled - scaled[0], axis=1), "scipy's pairs"


def crossing(vertices, faces):
    """Counts the faces that intersect others, by CGAL."""
    pairs = igl.copyleft.cgal.remesh_self_intersections(
        vertices, faces.astype(np.int64), detect_only=True, cutoff=10**9)[2]
    return set(np.unique(pairs).tolist())


def share(ours, theirs):
    return np.abs(ours / theirs - 1).max()


def along(ours, theirs):
    """Returns the mean and largest difference, as shares of the largest value."""
    reached = np.isfinite(ours)
    difference = np.abs(ours - theirs)[reached] / theirs[reached].max()
    return f"{difference.mean():.2e} ({difference.max():.2e})"


def row(folder):
    measured = json.loads((folder / "measured.json").read_text())
    original, simplified = mesh(folder / "original.ply"), mesh(folder / "simplified.ply")
    forward = distance(measured["samples"], simplified)
    backward = distance(measured["samples_simplified"], original)
    distances = [share(np.array(measured[name]), found) for name, found in
                 [("forward", forward), ("backward", backward)]]

    used = np.array(measured["vertices_in_use"])
    place = np.full(len(original[0]), -1)
    place[used] = np.arange(len(used))
    vertices, faces = original[0][used], place[original[1]]
    laplacian, mass = robust_laplacian.mesh_laplacian(vertices, faces)
    values, functions = eigenpairs(laplacian, mass, len(measured["eigenvalues"]))
    own = np.array(measured["eigenvalues"])
    nonzero = values > 1e-6 * values[-1] / len(values)
    solver = potpourri3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=True)
    geodesic = along(np.array(measured["geodesic"], dtype=float), solver.compute_distance(0))
    theirs, how = biharmonic(laplacian, mass, values, functions)
    spectral = along(np.array(measured["biharmonic"]), theirs)

    crossings = []
    for name, surface in [("crossing", original), ("crossing_simplified", simplified)]:
        ours, cgal = set(measured[name]), crossing(*surface)
        crossings.append(f"{len(ours)} / {len(cgal)}" + ("" if ours == cgal else f" ({len(ours - cgal)} only ours, "
                                                         f"{len(cgal - ours)} only CGAL's)"))
    return [folder.name, len(vertices), f"{max(distances):.1e}", f"{share(own[nonzero], values[nonzero]):.1e}", geodesic,
            f"{spectral} {how}", crossings[0], crossings[1]]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    heads = ["mesh", "vertices", "distance", "eigenvalues", "geodesic: mean (max)", "biharmonic: mean (max)",
             "crossing faces: ours / CGAL", "simplified"]
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads))
    for folder in map(Path, sys.argv[1:]):
        print("| " + " | ".join(map(str, row(folder))) + " |", flush=True)


main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints how results differ from those of Blender's Decimate modifier at equal numbers of faces, and what the operator costs.
Run it by an interpreter that has `bpy` and `neural_mesh`: `python blender/measure.py`."""

import sys
import time
from pathlib import Path

import bpy
import neural_mesh as nm
import numpy as np
from mathutils.bvhtree import BVHTree

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent / "tests")]
import blender  # noqa: E402
from blender import convert  # noqa: E402
from conftest import add_character, add_sphere, make_grid, positions_of, select  # noqa: E402

SAMPLES = 20_000
RATIOS = (0.5, 0.2, 0.1)


def add_monkey():
    """Adds Suzanne, subdivided twice."""
    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.object.shade_smooth()
    return monkey


def add_bumpy_sphere():
    """Adds a sphere with bumps, unwrapped with a seam."""
    sphere = add_sphere(128, 64)
    positions = positions_of(sphere.data)
    bumps = 1 + 0.1 * np.sin(6 * positions[:, :1]) * np.cos(5 * positions[:, 1:2]) * np.sin(7 * positions[:, 2:])
    sphere.data.vertices.foreach_set("co", (positions * bumps).astype(np.float32).ravel())
    bpy.ops.object.shade_smooth()
    return sphere


def add_person():
    """Adds the tests' character without its shape keys, which the modifier cannot be applied with."""
    person = add_character(n_keys=0)
    person.modifiers.clear()
    bpy.ops.object.shade_smooth()
    return person


def read_corners(item):
    """Returns positions, triangles, and normals and texture coordinates at corners."""
    source = convert.read_mesh(item, item.data)
    mesh = item.data
    corners = convert.get(mesh.loop_triangles, "loops", np.int32, source.triangles.size)
    normals = convert.get(mesh.corner_normals, "vector", np.float32, 3 * len(mesh.loops)).reshape(-1, 3)[corners].reshape(-1, 3, 3)
    uv = next(layer.values for layer in source.layers if layer.name == "UVMap").reshape(-1, 3, 2)
    return source.positions, source.triangles, normals, uv


def blend(values, weights):
    """Returns values of corners blended by weights."""
    return (values * weights[..., None]).sum(1)


def find_weights(points, corners):
    """Returns barycentric weights of points in triangles."""
    a, b, c = corners.transpose(1, 0, 2)
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    wu, wv = (w * u).sum(1), (w * v).sum(1)
    area = np.maximum(uu * vv - uv * uv, 1e-20)
    second, third = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    return np.clip(np.stack([1 - second - third, second, third], 1), 0, 1)


def measure_result(original, result):
    """Returns mean distance, mean error of texture coordinates, and mean angle between shading normals in degrees."""
    positions, triangles, normals, uv = original
    found, faces, found_normals, found_uv = result
    tree = BVHTree.FromPolygons(found.tolist(), faces.tolist())
    # Points of the original, evenly by area, and the nearest on the result.
    random = np.random.default_rng(0)
    corners = positions[triangles].astype(float)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = random.choice(len(triangles), SAMPLES, p=areas / areas.sum())
    weights = random.dirichlet((1, 1, 1), SAMPLES)
    points = blend(corners[chosen], weights)
    hits = [tree.find_nearest(point) for point in points.tolist()]
    nearest = np.array([hit[2] for hit in hits])
    places = find_weights(np.array([hit[0] for hit in hits]), found[faces[nearest]].astype(float))
    uv_errors = np.linalg.norm(blend(uv[chosen], weights) - blend(found_uv[nearest], places), axis=1)
    shading = [blend(normals[chosen], weights), blend(found_normals[nearest], places)]
    shading = [rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-9) for rows in shading]
    angles = np.degrees(np.arccos(np.clip((shading[0] * shading[1]).sum(1), -1, 1)))
    distance = nm.compare((positions, triangles), (found, faces))["distance_mean"]
    return np.array([distance, uv_errors.mean(), angles.mean()])


def decimate(item, n_faces, n_before):
    """Applies Blender's Decimate modifier (Collapse)."""
    modifier = item.modifiers.new("Decimate", "DECIMATE")
    modifier.ratio = n_faces / n_before
    bpy.ops.object.modifier_apply(modifier="Decimate")


def compare_with_decimate(name, add):
    """Prints a row for each ratio: faces of both, and each error over that of Decimate."""
    for ratio in RATIOS:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        item = add()
        item.data.calc_loop_triangles()
        original = read_corners(item)
        copy = item.copy()
        copy.data = item.data.copy()
        bpy.context.collection.objects.link(copy)
        select(item)
        bpy.ops.object.neural_mesh_simplify(ratio=ratio)
        n_faces = len(item.data.polygons)
        select(copy)
        decimate(copy, n_faces, len(original[1]))
        ours, theirs = read_corners(item), read_corners(copy)
        errors = measure_result(original, ours), measure_result(original, theirs)
        ratios = " | ".join(f"{value:.2f}" for value in errors[0] / errors[1])
        print(f"| {name} | {len(original[1])} | {n_faces}, {len(theirs[1])} | {ratios} |")


def measure_overhead():
    """Prints seconds of the operator and of `neural_mesh.simplify` alone on the same arrays of a million triangles."""
    positions, triangles = make_grid(708)
    for n_layers in (0, 1):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        mesh = bpy.data.meshes.new("Grid")
        item = bpy.data.objects.new("Grid", mesh)
        bpy.context.collection.objects.link(item)
        uv = positions[triangles][..., :2].reshape(-1, 2)
        carried = [convert.Layer("UVMap", "CORNER", "FLOAT2", uv)] * n_layers
        convert.write_mesh(item, convert.MeshArrays(positions, triangles, carried))
        select(item)
        attributes = {"uv": uv.reshape(-1, 3, 2)} if n_layers else None
        alone = []
        for _ in range(3):
            begun = time.perf_counter()
            options = {"attributes": attributes, "weld": False, "check": False, "keep_components": True}
            nm.simplify(positions, triangles, faces=len(triangles) // 10, **options)
            alone.append(time.perf_counter() - begun)
        begun = time.perf_counter()
        bpy.ops.object.neural_mesh_simplify(ratio=0.1)
        whole = time.perf_counter() - begun
        print(f"{len(triangles)} triangles, {n_layers} UV maps: operator {whole:.2f} s, simplify {min(alone):.2f} s, {whole / min(alone):.2f}")


if __name__ == "__main__":
    blender.register()
    print("| mesh | triangles | faces, Decimate's | distance | texture coordinates | normals |")
    compare_with_decimate("Suzanne", add_monkey)
    compare_with_decimate("sphere with bumps", add_bumpy_sphere)
    compare_with_decimate("character", add_person)
    measure_overhead()
    # Blender may wait forever at the end of a process that has its classes still.
    blender.unregister()

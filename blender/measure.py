# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares results with those of Blender's Decimate modifier at equal numbers of faces, and times the operator.
Run it by an interpreter that has `bpy` and `neural_mesh`: `python blender/measure.py [errors | poses | times]`."""

import os
import subprocess
import sys
import tempfile
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
# Number of timings of each of two things, in turns.
N_TURNS = 5


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
    """Returns mean distance, median error of texture coordinates, and mean angle between shading normals in degrees."""
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
    # Near a seam the closest point may be across it, with unrelated coordinates, and a few such points would dominate a mean.
    return np.array([distance, np.median(uv_errors), angles.mean()])


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


def add_face(moves):
    """Adds Suzanne with four shape keys and a head that turns, by an animation if it `moves`; returns it and its armature."""
    face = add_monkey()
    positions = positions_of(face.data)
    face.shape_key_add(name="Basis")
    # Middle, radius and offset of a bump, which the other half of the face mirrors.
    bumps = {
        "Smile": ((0.35, -0.75, -0.6), 0.2, (0.12, 0, 0.15)),
        "Open": ((0, -0.75, -0.8), 0.3, (0, 0, -0.1)),
        "Brow": ((0.35, -0.7, 0.55), 0.25, (0, 0, 0.12)),
        "Puff": ((0.6, -0.5, -0.2), 0.25, (0.15, -0.05, 0)),
    }
    for name, (middle, radius, offset) in bumps.items():
        moved = positions.copy()
        for side in (np.array([1, 1, 1]), np.array([-1, 1, 1])):
            weights = np.exp(-((positions - side * middle) ** 2).sum(1) / radius**2)
            moved += weights[:, None] * (side * offset)
        face.shape_key_add(name=name).data.foreach_set("co", moved.astype(np.float32).ravel())
    armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, height in (("Neck", -1), ("Head", 0)):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = (0, 0, height), (0, 0, height + 1), armature.data.edit_bones.get("Neck") if height == 0 else None
    bpy.ops.object.mode_set(mode="OBJECT")
    share = 1 / (1 + np.exp(-8 * positions[:, 2]))
    for name, weights in (("Neck", 1 - share), ("Head", share)):
        group = face.vertex_groups.new(name=name)
        for vertex, weight in enumerate(weights.tolist()):
            group.add([vertex], weight, "REPLACE")
    face.modifiers.new("Armature", "ARMATURE").object = armature
    head = armature.pose.bones["Head"]
    head.rotation_mode = "XYZ"
    for frame, angles in ((1, (0, 0, -0.7)), (15, (0.4, 0, 0.3)), (30, (-0.3, 0, 0.7))) if moves else ():
        head.rotation_euler = angles
        head.keyframe_insert("rotation_euler", frame=frame)
    head.rotation_euler = (0, 0, 0)
    return face, armature


def read_seen(item):
    """Returns positions and triangles of an object as its keys, armature and modifiers show it."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    mesh.calc_loop_triangles()
    triangles = convert.get(mesh.loop_triangles, "vertices", np.int32, 3 * len(mesh.loop_triangles)).reshape(-1, 3)
    seen = positions_of(mesh), triangles
    evaluated.to_mesh_clear()
    return seen


def compare_in_poses(moves, ratio=0.2):
    """Prints the largest distance of a face in each state over that of a live Decimate modifier, which sees the state."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    face, armature = add_face(moves)
    ours, theirs = face.copy(), face.copy()
    for copy in (ours, theirs):
        copy.data = face.data.copy()
        bpy.context.collection.objects.link(copy)
    n_before = len(read_seen(face)[1])
    select(ours)
    bpy.ops.object.neural_mesh_simplify(ratio=ratio)
    armature.animation_data_clear()
    theirs.modifiers.new("Decimate", "DECIMATE").ratio = len(ours.data.polygons) / n_before
    names = [block.name for block in face.data.shape_keys.key_blocks[1:]]
    states = {"rest": ([], 0), **{name: ([name], 0) for name in names}, "all keys": (names, 0), "pose": ([], 0.6), "both": (names, 0.6)}
    row = []
    for state, (raised, angle) in states.items():
        armature.pose.bones["Head"].rotation_euler = (0, 0, angle)
        for item in (face, ours, theirs):
            for block in item.data.shape_keys.key_blocks:
                block.value = float(block.name in raised)
        bpy.context.view_layer.update()
        original = read_seen(face)
        distances = [nm.compare(original, read_seen(item), samples=100_000)["distance_max"] for item in (ours, theirs)]
        row.append(f"{state} {distances[0] / distances[1]:.2f}")
    print(f"face {'that moves' if moves else 'at rest'}, {len(ours.data.polygons)} triangles: {', '.join(row)}", flush=True)


def measure_overhead():
    """Prints seconds of the operator on a million triangles, of `neural_mesh.simplify` alone with the same arrays, and of the program."""
    positions, triangles = make_grid(708)
    n_faces = len(triangles) // 10
    for n_layers, keeps_shading in ((0, False), (0, True), (1, False), (1, True)):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        mesh = bpy.data.meshes.new("Grid")
        item = bpy.data.objects.new("Grid", mesh)
        bpy.context.collection.objects.link(item)
        uv = positions[triangles][..., :2].reshape(-1, 2)
        carried = [convert.Layer("UVMap", "CORNER", "FLOAT2", uv)] * n_layers
        convert.write_mesh(item, convert.MeshArrays(positions, triangles, carried))
        select(item)
        attributes = {"uv": uv.reshape(-1, 3, 2)} if n_layers else {}
        if keeps_shading:
            attributes["normals"] = convert.read_mesh(item, mesh, keeps_shading).normals
        options = {"attributes": attributes or None, "weld": False, "check": False, "keep_components": True}
        # The minimum of alternating runs reduces the influence of other work on the machine.
        seconds = {"operator": [], "simplify": []}
        for _ in range(N_TURNS):
            select(item)
            copy = item.copy()
            copy.data = mesh.copy()
            bpy.context.collection.objects.link(copy)
            select(copy)
            begun = time.perf_counter()
            bpy.ops.object.neural_mesh_simplify(ratio=0.1, keep_shading=keeps_shading)
            seconds["operator"].append(time.perf_counter() - begun)
            assert len(copy.data.polygons) <= n_faces + 1
            bpy.data.meshes.remove(copy.data)
            begun = time.perf_counter()
            nm.simplify(positions, triangles, faces=n_faces, **options)
            seconds["simplify"].append(time.perf_counter() - begun)
        operator, alone = (min(values) for values in seconds.values())
        carried = f"{n_layers} UV maps, {'with' if keeps_shading else 'without'} Keep Shading"
        print(f"{len(triangles)} triangles, {carried}: operator {operator:.2f} s, simplify {alone:.2f} s, {operator / alone:.2f}", flush=True)
    measure_program(positions, triangles)


def measure_program(positions, triangles):
    """Prints seconds of the program from file to file, where the environment names it."""
    program = os.environ.get("NEURAL_MESH_PROGRAM")
    if not program:
        return
    with tempfile.TemporaryDirectory() as folder:
        given, light = Path(folder) / "grid.ply", Path(folder) / "light.ply"
        nm.simplify(positions, triangles, ratio=1.0, out=given)
        seconds = []
        for _ in range(N_TURNS):
            begun = time.perf_counter()
            subprocess.run([program, "simplify", given, "-o", light, "--faces", str(len(triangles) // 10), "--force"], check=True, capture_output=True)
            seconds.append(time.perf_counter() - begun)
    print(f"{len(triangles)} triangles: program {min(seconds):.2f} s")


if __name__ == "__main__":
    blender.register()
    if "errors" not in sys.argv and "times" not in sys.argv:
        compare_in_poses(moves=False)
        compare_in_poses(moves=True)
    if "poses" not in sys.argv and "times" not in sys.argv:
        print("| mesh | triangles | faces, Decimate's | distance | texture coordinates | normals |")
        compare_with_decimate("Suzanne", add_monkey)
        compare_with_decimate("sphere with bumps", add_bumpy_sphere)
        compare_with_decimate("character", add_person)
    if "errors" not in sys.argv and "poses" not in sys.argv:
        measure_overhead()
    sys.stdout.flush()
    # Blender may wait forever at the end of a process that has its classes still.
    os._exit(0)

"""Simplifiers: this project's program and its peers, each from file to file."""

import importlib.util
import shutil
import subprocess
from dataclasses import dataclass
from typing import Callable

import trimesh

import gltf

SECONDS = 300
# Moves vertices and attributes, and merges across seams.
MOVING = ("-sv", "-sp")


@dataclass
class Method:
    name: str
    # Takes original, result, ratio, and the number of faces or None; returns whether the result is there.
    run: Callable


def methods(kind, given):
    """Returns the methods for a kind of asset; the first one decides on the number of faces."""
    own = [
        Method("neural-mesh", lambda *job: run_program(given.program, [], *job)),
        Method("neural-mesh looks", lambda *job: run_program(given.program, ["--optimize", "looks"], *job)),
    ]
    on_scene = kind == "scene"
    run_gltfpack_on = run_gltfpack_on_scene if on_scene else run_gltfpack_on_mesh
    peers = [
        ("gltfpack", lambda *job: run_gltfpack_on([given.gltfpack], *job), given.gltfpack),
        (f"gltfpack {' '.join(MOVING)}", lambda *job: run_gltfpack_on([given.gltfpack, *MOVING], *job), given.gltfpack),
        ("Blender", run_blender_on_scene if on_scene else run_blender, has_package("bpy")),
    ]
    if not on_scene:  # the other two know neither textures nor materials
        peers += [
            ("fast_simplification", run_fast_simplification, has_package("fast_simplification")),
            ("CGAL Lindstrom-Turk", lambda *job: run_cgal(given.cgal, *job), given.cgal),
        ]
    return own + [Method(name, run) for name, run, is_there in peers if is_there]


def has_package(name):
    return importlib.util.find_spec(name) is not None


def run_command(words, result):
    """Runs a program; returns whether it wrote the result."""
    if shutil.which(str(words[0])) is None:
        return False
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0 and result.exists()


def run_program(program, options, original, result, ratio, faces):
    size = ["--faces", faces] if faces else ["--ratio", ratio]
    return run_command([program, "simplify", original, "-o", result, "--force", "--quiet", *size, *options], result)


def run_gltfpack(words, original, result, ratio):
    # By default it stops at an error of 1 %.
    return run_command([*words, "-i", original, "-o", result, "-noq", "-kn", "-km", "-si", ratio, "-se", 1], result)


def share_of_faces(original, faces):
    return faces / int(gltf.Asset(original).count_faces().sum())


def run_gltfpack_on_scene(words, original, result, ratio, faces):
    return run_gltfpack(words, original, result, share_of_faces(original, faces))


def run_gltfpack_on_mesh(words, original, result, ratio, faces):
    """Runs gltfpack on the mesh with its normals, which it counts as meshoptimizer's attributes."""
    mesh, given, made = load(original), result.with_suffix(".given.obj"), result.with_suffix(".glb")
    mesh.export(given, include_normals=True)
    if not run_gltfpack(words, given, made, faces / len(mesh.faces)):
        return False
    light = trimesh.load(made, force="mesh")
    return write(result, light.vertices, light.faces)


def run_cgal(program, original, result, ratio, faces):
    return run_command([program, "lt", original, result, faces], result)


def load(path):
    mesh = trimesh.load(path, process=False)
    mesh.merge_vertices()
    return mesh


def write(result, vertices, faces):
    trimesh.Trimesh(vertices, faces, process=False).export(result)
    return True


def run_fast_simplification(original, result, ratio, faces):
    import fast_simplification

    mesh = load(original)
    return write(result, *fast_simplification.simplify(mesh.vertices, mesh.faces, target_count=faces))


def run_blender(original, result, ratio, faces):
    import bpy

    mesh = load(original)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    thing = bpy.data.objects.new("mesh", data)
    bpy.context.collection.objects.link(thing)
    decimate = thing.modifiers.new("decimate", "DECIMATE")
    decimate.ratio = faces / len(mesh.faces)
    light = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    light.calc_loop_triangles()
    vertices = [list(vertex.co) for vertex in light.vertices]
    return write(result, vertices, [list(triangle.vertices) for triangle in light.loop_triangles])


def run_blender_on_scene(original, result, ratio, faces):
    """Decimates every mesh of a scene by one ratio, as a person would who selects all."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(original), merge_vertices=True)
    things = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    share = share_of_faces(original, faces)
    for thing in things:
        thing.modifiers.new("decimate", "DECIMATE").ratio = share
    bpy.ops.export_scene.gltf(filepath=str(result), export_apply=True)
    return result.exists()

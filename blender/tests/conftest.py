# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the extension once for all tests and gives each test an empty scene.
The meshes that several tests use are made here."""

import os
import sys
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))
import blender  # noqa: E402


@pytest.fixture(scope="session", autouse=True)
def registered():
    blender.register()
    yield
    blender.unregister()


def pytest_sessionfinish(session, exitstatus):
    session.config.exit_status = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    # Blender crashes or waits forever at the end of a process that has written a glTF.
    sys.stdout.flush()
    os._exit(getattr(config, "exit_status", 1))


@pytest.fixture(autouse=True)
def empty_scene(registered):
    bpy.ops.wm.read_factory_settings(use_empty=True)


def add_sphere(segments=48, rings=24, location=(0, 0, 0)):
    """Adds a sphere with texture coordinates, which are split along a seam."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=rings, location=location)
    return bpy.context.object


def add_character(n_keys=20, n_groups=30, segments=96, rings=48):
    """Adds a bent capsule with an armature of `n_groups` bones, one vertex group each, and `n_keys` shape keys."""
    body = add_sphere(segments, rings)
    mesh = body.data
    positions = positions_of(mesh)
    positions[:, 2] *= 3
    positions[:, 0] += 0.3 * np.sin(positions[:, 2])
    mesh.vertices.foreach_set("co", positions.ravel())
    body.name = mesh.name = "Character"
    armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    heights = np.linspace(-3, 3, n_groups + 1)
    for i in range(n_groups):
        bone = armature.data.edit_bones.new(f"Bone{i}")
        bone.head, bone.tail = (0, 0, heights[i]), (0, 0, heights[i + 1])
    bpy.ops.object.mode_set(mode="OBJECT")
    add_weights(body, positions, n_groups)
    add_keys(body, positions, n_keys)
    body.modifiers.new("Armature", "ARMATURE").object = armature
    select(body)
    return body


def add_weights(body, positions, n_groups):
    """Adds vertex groups that blend linearly from each bone to the next."""
    along = (positions[:, 2] + 3) / 6 * (n_groups - 1)
    for i in range(n_groups):
        group = body.vertex_groups.new(name=f"Bone{i}")
        weights = 1 - np.abs(along - i)
        for vertex in np.flatnonzero(weights > 0):
            group.add([int(vertex)], float(weights[vertex]), "REPLACE")


def move_by_key(positions, i):
    """Returns the offsets of shape key `i`, smooth over the body."""
    directions = np.stack([np.sin(positions[:, 2] + i), np.cos(positions[:, 2] * 0.5 + i), np.sin(positions[:, 0] - i)], axis=1)
    return 0.1 * directions


def add_keys(body, positions, n_keys):
    """Adds a basis and shape keys with values, a driver and an action."""
    if n_keys == 0:
        return
    body.shape_key_add(name="Basis")
    for i in range(n_keys):
        key = body.shape_key_add(name=f"Key{i}")
        key.data.foreach_set("co", (positions + move_by_key(positions, i)).astype(np.float32).ravel())
        key.slider_max = 2
        key.value = 0.01 * i
    blocks = body.data.shape_keys.key_blocks
    blocks["Key2"].mute = True
    blocks["Key3"].relative_key = blocks["Key1"]
    blocks["Key4"].vertex_group = "Bone3"
    blocks["Key5"].keyframe_insert("value", frame=1)
    blocks["Key6"].driver_add("value").driver.expression = "0.25"


def make_material(name, roughness):
    """Returns a material, its node tree and the input for its base color."""
    material = bpy.data.materials.new(name)
    if not material.use_nodes:
        material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = roughness
    return material, material.node_tree, shader.inputs["Base Color"]


def make_grid(n):
    """Returns positions and triangles of a wavy square of n x n vertices."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    positions = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([corner[:, None] + [0, 1, n + 1], corner[:, None] + [0, n + 1, n]])
    return positions, triangles.astype(np.int32)


def positions_of(mesh):
    """Returns the positions of a mesh, n x 3."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def select(*objects):
    """Selects these objects alone."""
    for item in bpy.context.scene.objects:
        item.select_set(item in objects)
    bpy.context.view_layer.objects.active = objects[0]


def is_closed(mesh):
    """Returns whether every edge has two faces."""
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    triangles = vertices.reshape(-1, 3)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def n_triangles(mesh):
    """Returns the number of triangles of a mesh's polygons."""
    mesh.calc_loop_triangles()
    return len(mesh.loop_triangles)


def count_seen(item):
    """Returns the number of triangles that an object shows with its modifiers."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    n = n_triangles(evaluated.to_mesh())
    evaluated.to_mesh_clear()
    return n


class Layout:
    """Mock of a panel's layout, and of what it returns, that records what is drawn."""

    def __init__(self):
        self.drawn = []

    def __getattr__(self, name):
        def draw(*arguments, **options):
            self.drawn.append((name, arguments[-1] if arguments else options.get("text")))
            return self if name in ("row", "column") else SimpleNamespace()

        return draw

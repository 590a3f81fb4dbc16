# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the picture of the guide: Suzanne, and a tenth of her triangles by the extension and by the Decimate modifier.
Run it by an interpreter that has `bpy` and `neural_mesh`: `python blender/picture.py OUT.png`."""

import os
import sys
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent / "tests")]
import blender  # noqa: E402
from blender.measure import add_monkey, decimate  # noqa: E402
from conftest import select  # noqa: E402

RATIO = 0.05
SPACING = 2.75
SIZE = (840, 270)
SAMPLES = 64


def make_material():
    """Returns a material with a checkerboard by texture coordinates."""
    material = bpy.data.materials.new("Checker")
    if not material.use_nodes:
        material.use_nodes = True
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = 0.35
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = 24
    checker.inputs["Color1"].default_value = (0.8, 0.8, 0.8, 1)
    checker.inputs["Color2"].default_value = (0.3, 0.45, 0.65, 1)
    coordinates = tree.nodes.new("ShaderNodeUVMap")
    tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    return material


def add_heads():
    """Adds the original, the extension's result and that of the modifier, side by side."""
    original = add_monkey()
    original.data.materials.append(make_material())
    original.data.calc_loop_triangles()
    n_triangles = len(original.data.loop_triangles)
    original.rotation_euler = (-0.25, 0, 0.5)
    copies = []
    for column in (0, 1):
        copy = original.copy()
        copy.data = original.data.copy()
        copy.location.x = column * SPACING
        bpy.context.collection.objects.link(copy)
        copies.append(copy)
    original.location.x = -SPACING
    ours, theirs = copies
    select(ours)
    bpy.ops.object.neural_mesh_simplify(ratio=RATIO)
    select(theirs)
    decimate(theirs, len(ours.data.polygons), n_triangles)
    print(n_triangles, len(ours.data.polygons), len(theirs.data.polygons))


def add_light_and_camera():
    """Adds a sun, a grey world and a camera in front."""
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 3, 0.1
    sun.rotation_euler = (0.7, 0.5, 0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (-0.12, -20, 0.05), (1.5708, 0, 0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 8.3
    for item in (sun, camera):
        bpy.context.collection.objects.link(item)
    bpy.context.scene.camera = camera
    world = bpy.data.worlds.new("World")
    world.color = (0.6, 0.6, 0.6)
    bpy.context.scene.world = world


def render(path):
    """Renders the scene by Cycles."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", SAMPLES, 1
    scene.cycles.use_denoising = True
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    scene.render.filepath = str(Path(path).absolute())
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    blender.register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_heads()
    add_light_and_camera()
    render(sys.argv[1])
    sys.stdout.flush()
    os._exit(0)

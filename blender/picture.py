# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the picture of the guide: Suzanne, and a twentieth of her triangles by the extension and by the Decimate modifier.
Above with a texture, below with the edges. Run it by an interpreter that has `bpy` and `neural_mesh`: `python blender/picture.py OUT.png`."""

import os
import sys
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent / "tests")]
import blender  # noqa: E402
from blender.measure import add_monkey, decimate  # noqa: E402
from conftest import make_material, select  # noqa: E402

RATIO = 0.05
SPACING = (2.75, 2.1)
SIZE = (840, 500)
SAMPLES = 64
BACKGROUND = (0.9, 0.91, 0.93, 1)
INK = (0.02, 0.02, 0.03, 1)


def make_checkered():
    """Returns a material with a checkerboard by texture coordinates."""
    material, tree, color = make_material("Checker", roughness=0.35)
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = 24
    checker.inputs["Color1"].default_value = (0.8, 0.8, 0.8, 1)
    checker.inputs["Color2"].default_value = (0.3, 0.45, 0.65, 1)
    coordinates = tree.nodes.new("ShaderNodeUVMap")
    tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], color)
    return material


def make_wired():
    """Returns a material that draws the edges of triangles."""
    material, tree, color = make_material("Edges", roughness=0.6)
    wire = tree.nodes.new("ShaderNodeWireframe")
    wire.use_pixel_size = True
    wire.inputs["Size"].default_value = 0.35
    blend = tree.nodes.new("ShaderNodeMix")
    blend.data_type = "RGBA"
    blend.inputs["A"].default_value, blend.inputs["B"].default_value = (0.6, 0.67, 0.76, 1), INK
    tree.links.new(wire.outputs["Fac"], blend.inputs["Factor"])
    tree.links.new(blend.outputs["Result"], color)
    return material


def make_glowing(name, color):
    """Returns a material of one color, whatever the light."""
    material, tree, _ = make_material(name, roughness=1)
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = color
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    return material


def link(name, data, location, rotation=(0, 0, 0)):
    """Adds an object with this data and returns it."""
    item = bpy.data.objects.new(name, data)
    item.location, item.rotation_euler = location, rotation
    bpy.context.collection.objects.link(item)
    return item


def add_heads():
    """Adds the original, the extension's result and that of the modifier, each with a copy below that shows its edges."""
    original = add_monkey()
    original.data.materials.append(make_checkered())
    original.data.calc_loop_triangles()
    n_triangles = len(original.data.loop_triangles)
    original.location, original.rotation_euler = (-SPACING[0], 0, SPACING[1] / 2), (-0.25, 0, 0.5)
    heads = [original] + [link("Head", original.data.copy(), (x, 0, SPACING[1] / 2), original.rotation_euler) for x in (0, SPACING[0])]
    _, ours, theirs = heads
    select(ours)
    bpy.ops.object.neural_mesh_simplify(ratio=RATIO)
    n_left = len(ours.data.polygons)
    select(theirs)
    decimate(theirs, n_left, n_triangles)
    wired, ink = make_wired(), make_glowing("Ink", INK)
    for head, title in zip(heads, ("Original", "Neural Mesh", "Decimate"), strict=True):
        head.data.calc_loop_triangles()
        copy = link("Edges", head.data.copy(), head.location, head.rotation_euler)
        copy.location.z -= SPACING[1]
        copy.data.materials[0] = wired
        text = bpy.data.curves.new("Title", "FONT")
        text.body, text.size, text.align_x = f"{title}: {len(head.data.loop_triangles):,} triangles", 0.19, "CENTER"
        text.materials.append(ink)
        link("Title", text, (head.location.x, -2, -2.33), (1.5708, 0, 0))
        print(text.body)


def add_light_and_camera():
    """Adds a sun, a grey world, a light background and a camera in front."""
    sun = link("Sun", bpy.data.lights.new("Sun", "SUN"), (0, 0, 0), (0.7, 0.5, 0))
    sun.data.energy, sun.data.angle = 2.5, 0.1
    camera = link("Camera", bpy.data.cameras.new("Camera"), (-0.12, -20, -0.05), (1.5708, 0, 0))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 8.3
    bpy.context.scene.camera = camera
    wall = bpy.data.meshes.new("Wall")
    wall.from_pydata([(-9, 9, -9), (9, 9, -9), (9, 9, 9), (-9, 9, 9)], [], [(0, 1, 2, 3)])
    wall.materials.append(make_glowing("Wall", BACKGROUND))
    link("Wall", wall, (0, 0, 0))
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

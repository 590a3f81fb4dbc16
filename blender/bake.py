# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the materials of an original to one new material of its simplified mesh, by Cycles from the selected to the active object.
Color, roughness and metalness are baked as light that copies of the materials emit; normals are those of the tangent space."""

from contextlib import contextmanager

import bpy
import neural_mesh as nm
import numpy as np

from . import convert
from .job import Refusal

UV_NAME = "Baked"
# Inputs of a Principled BSDF that are baked, whether they are colours, and the values of a material without such a node.
CHANNELS = {"Base Color": (True, (0.8, 0.8, 0.8, 1.0)), "Roughness": (False, 0.5), "Metallic": (False, 0.0)}
# Largest distance from the original within which rays begin, over the distance that was measured, and at least as a share of the diagonal.
EXTRUSION_FACTOR, LEAST_EXTRUSION = 1.5, 0.001
# Samples of the distance.
SAMPLES = 5000
# Samples of each pixel: textures have no noise.
PIXEL_SAMPLES = 4
# Space between islands, as a share of the texture.
ISLAND_MARGIN = 0.005
# Angle between faces above which islands part, in radians: 66 degrees.
ISLAND_ANGLE = 1.152


def bake_material(context, original, item, source, size):
    """Gives an object a new material with textures of `size` pixels a side, baked from a copy of its original.

    `original` is the copy, whose materials are its own and may be changed; `source` are its arrays.
    """
    unwrap(context, item)
    material, images = make_material(item.name, size)
    item.data.materials.clear()
    item.data.materials.append(material)
    item.data.polygons.foreach_set("material_index", np.zeros(len(item.data.polygons), np.int32))
    materials = [slot.material for slot in original.material_slots if slot.material is not None]
    with bake_settings(context, original, item):
        bake = context.scene.render.bake
        bake.cage_extrusion = find_extrusion(source, item)
        bake_image(material, images["Normal"], "NORMAL")
        for channel, (_, default) in CHANNELS.items():
            for each in materials:
                emit_channel(each, channel, default)
            bake_image(material, images[channel], "EMIT")
    connect_images(material, images)


def find_extrusion(source, item):
    """Returns the distance from the result at which rays begin: outside of the original."""
    result = convert.read_mesh(item, item.data)
    found = nm.compare((source.positions, source.triangles), (result.positions, result.triangles), samples=SAMPLES)
    diagonal = float(np.linalg.norm(np.ptp(source.positions, axis=0)))
    return max(EXTRUSION_FACTOR * found["distance_max"], LEAST_EXTRUSION * diagonal)


def unwrap(context, item):
    """Adds texture coordinates without overlaps, which become the active ones."""
    mesh = item.data
    layer = mesh.uv_layers.get(UV_NAME) or mesh.uv_layers.new(name=UV_NAME)
    if layer is None:
        raise Refusal(f"{item.name} has eight UV maps: remove one before baking")
    layer.active = layer.active_render = True
    with selected(context, item):
        bpy.ops.object.mode_set(mode="EDIT")
        try:
            bpy.ops.mesh.reveal()
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.uv.smart_project(angle_limit=ISLAND_ANGLE, island_margin=ISLAND_MARGIN)
        finally:
            bpy.ops.object.mode_set(mode="OBJECT")


@contextmanager
def selected(context, item, *others):
    """Makes an object active and selects it with others, and restores the selection afterwards."""
    layer = context.view_layer
    before, active = list(context.selected_objects), layer.objects.active
    for other in before:
        other.select_set(False)
    for one in (item, *others):
        one.select_set(True)
    layer.objects.active = item
    try:
        yield
    finally:
        for one in (item, *others):
            one.select_set(False)
        for other in before:
            other.select_set(True)
        layer.objects.active = active


@contextmanager
def bake_settings(context, original, item):
    """Sets Cycles up to bake from one object to another, and restores the settings of the scene afterwards."""
    render, cycles, bake = context.scene.render, context.scene.cycles, context.scene.render.bake
    wanted = {
        render: {"engine": "CYCLES"},
        cycles: {"samples": PIXEL_SAMPLES, "device": "CPU", "use_denoising": False},
        bake: {
            "use_selected_to_active": True,
            "use_cage": False,
            "max_ray_distance": 0.0,
            "cage_extrusion": 0.0,
            "normal_space": "TANGENT",
            "use_clear": True,
            "margin": 16,
            "target": "IMAGE_TEXTURES",
        },
    }
    before = [(owner, name, getattr(owner, name)) for owner, values in wanted.items() for name in values]
    for owner, values in wanted.items():
        for name, value in values.items():
            setattr(owner, name, value)
    try:
        with selected(context, item, original):
            yield
    finally:
        for owner, name, value in before:
            setattr(owner, name, value)


def make_material(name, size):
    """Returns a new material with a Principled BSDF, and an empty image for each channel."""
    material = bpy.data.materials.new(f"{name}_Baked")
    if not material.use_nodes:
        material.use_nodes = True
    images = {}
    for channel in (*CHANNELS, "Normal"):
        image = bpy.data.images.new(f"{name} {channel}", size, size)
        if channel != "Base Color":
            image.colorspace_settings.name = "Non-Color"
        images[channel] = image
    return material, images


def bake_image(material, image, kind):
    """Bakes into an image, which has to be that of the material's active node."""
    nodes = material.node_tree.nodes
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    nodes.active = node
    try:
        bpy.ops.object.bake(type=kind)
    finally:
        nodes.remove(node)
    image.pack()


def emit_channel(material, channel, default):
    """Has a material emit an input of its Principled BSDF: what is linked to it, or its value."""
    if not material.use_nodes:
        material.use_nodes = True
    tree = material.node_tree
    shader = next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    emission = tree.nodes.new("ShaderNodeEmission")
    if shader is not None and shader.inputs[channel].links:
        tree.links.new(shader.inputs[channel].links[0].from_socket, emission.inputs["Color"])
    else:
        value = default if shader is None else shader.inputs[channel].default_value
        emission.inputs["Color"].default_value = value if hasattr(value, "__len__") else (value, value, value, 1)
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])


def connect_images(material, images):
    """Connects the images with the shader, by the new texture coordinates."""
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    coordinates = tree.nodes.new("ShaderNodeUVMap")
    coordinates.uv_map = UV_NAME
    coordinates.location = (-900, 0)
    for row, (channel, image) in enumerate(images.items()):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        node.location = (-600, 300 - 300 * row)
        tree.links.new(coordinates.outputs["UV"], node.inputs["Vector"])
        color = node.outputs["Color"]
        if channel == "Normal":
            bump = tree.nodes.new("ShaderNodeNormalMap")
            bump.uv_map = UV_NAME
            bump.location = (-300, 300 - 300 * row)
            tree.links.new(color, bump.inputs["Color"])
            color = bump.outputs["Normal"]
        tree.links.new(color, shader.inputs[channel])


@contextmanager
def copied_original(context, item):
    """Keeps a copy of an object, with materials of its own, for as long as the block runs."""
    copy = item.copy()
    copy.data = item.data.copy()
    materials = []
    for slot, of_item in zip(copy.material_slots, item.material_slots):
        if of_item.material is not None:
            # The copy of the mesh has the slots; those of the object are its own already.
            slot.material = of_item.material.copy()
            materials.append(slot.material)
    if not materials:
        materials.append(bpy.data.materials.new("Baked"))
        copy.data.materials.append(materials[0])
    context.collection.objects.link(copy)
    try:
        yield copy
    finally:
        mesh = copy.data
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        for material in materials:
            bpy.data.materials.remove(material)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes levels of detail of an object: copies `NAME_LOD0`, `NAME_LOD1` and so on in a collection `NAME_LODs`.
A property `lod` of the original chooses by drivers which one shows; -1 shows the original."""

from dataclasses import replace

import bpy
from mathutils import Matrix

from . import scene
from .job import Refusal

PROPERTY = "lod"


def parse_ratios(text):
    """Returns the shares that a text lists, each above 0 and at most 1."""
    try:
        ratios = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        ratios = []
    if not ratios or not all(0 < ratio <= 1 for ratio in ratios):
        raise Refusal(f"Ratios are numbers above 0 and at most 1, such as 1, 0.5, 0.25: not {text!r}")
    return ratios


def plan_levels(tasks, ratios):
    """Returns for each task its levels, as tasks with a number of faces."""
    levels = []
    for task in tasks:
        counts = [max(round(ratio * len(task.source.triangles)), 1) for ratio in ratios]
        levels.append([replace(task, size={"faces": count}, name=f"{task.name}_LOD{i}") for i, count in enumerate(counts)])
    return levels


def make_levels(context, tasks, options):
    """Makes the objects of one original's levels, in place of those of an earlier call."""
    original = tasks[0].owner
    collection = make_collection(original)
    original[PROPERTY] = 0
    original.id_properties_ui(PROPERTY).update(
        min=-1, max=len(tasks) - 1, description="Visible level of detail; -1 shows the original"
    )
    for level, task in enumerate(tasks):
        task.owner = copy_object(original, task.name)
        collection.objects.link(task.owner)
        if task.result is None and options.apply_modifiers:
            task.result = task.source
        if task.result is not None:
            scene.put_in_place(context, task, options)
        drive_visibility(task.owner, original, f"lod != {level}")
    drive_visibility(original, original, f"0 <= lod < {len(tasks)}")


def make_collection(original):
    """Returns an empty collection for the levels of an object, in the collection that the object is in."""
    name = f"{original.name}_LODs"
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        original.users_collection[0].children.link(collection)
    for item in list(collection.objects):
        mesh = item.data
        bpy.data.objects.remove(item)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    return collection


def copy_object(original, name):
    """Returns a copy of an object with a mesh of its own, which follows the original."""
    copy = original.copy()
    copy.data = original.data.copy()
    copy.name = copy.data.name = name
    # The original's motion, constraints and drivers act on the copy through its parent.
    copy.animation_data_clear()
    copy.constraints.clear()
    copy.parent, copy.parent_type = original, "OBJECT"
    copy.matrix_parent_inverse = Matrix.Identity(4)
    copy.matrix_basis = Matrix.Identity(4)
    copy.pop(PROPERTY, None)
    return copy


def drive_visibility(item, original, expression):
    """Hides an object in viewport and render where the expression of `lod` is true."""
    for path in ("hide_viewport", "hide_render"):
        item.driver_remove(path)
        driver = item.driver_add(path).driver
        driver.expression = expression
        variable = driver.variables.new()
        variable.name = "lod"
        variable.targets[0].id = original
        variable.targets[0].data_path = f'["{PROPERTY}"]'

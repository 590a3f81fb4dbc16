# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes levels of detail of an object: copies `NAME_LOD0`, `NAME_LOD1` and so on under one empty `NAME_LODs`, in a collection of that name.
The original stays as it is. A property `lod` of the empty chooses by drivers which level shows; -1 shows the original."""

from dataclasses import replace

import bpy
from mathutils import Matrix

from . import scene
from .job import Refusal
from .simplify import share_faces, simplify_tasks

PROPERTY = "lod"
# Property of the empty: the object that the levels are made of.
ORIGINAL = "neural_mesh_original"
# Property of each level: its number, 0 for the finest.
LEVEL = "neural_mesh_level"
# Property of each level: its largest distance from the original, in units of the scene.
ERROR = "neural_mesh_distance"


def parse_ratios(text):
    """Returns the shares that a text lists, each above 0 and at most 1."""
    try:
        ratios = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        ratios = []
    if not ratios or not all(0 < ratio <= 1 for ratio in ratios):
        raise Refusal(f"Ratios are numbers above 0 and at most 1, such as 1, 0.5, 0.25: not {text!r}")
    return ratios


def find_group(item):
    """Returns the empty of an object's levels: for the empty itself, a level, or their original; `None` without levels."""
    if ORIGINAL in item:
        return item
    if LEVEL in item:
        return item.parent if item.parent is not None and ORIGINAL in item.parent else None
    return next((other for other in bpy.data.objects if other.get(ORIGINAL) == item), None)


def find_levels(group):
    """Returns the levels under an empty, the finest first."""
    return sorted((child for child in group.children if LEVEL in child), key=lambda child: child[LEVEL])


def find_original(item):
    """Returns the original of a level or of the empty above levels, `None` if it is gone, and any other object itself."""
    if LEVEL not in item and ORIGINAL not in item:
        return item
    group = find_group(item)
    original = group and group[ORIGINAL]
    return original if original is not None and original.users_scene else None


def find_originals(objects):
    """Returns the meshes to make levels of: the originals of selected levels and empties, and all others as they are."""
    originals = {item: find_original(item) for item in objects}
    for item, original in originals.items():
        if original is None:
            raise Refusal(f"{item.name} is a level of an object that is gone: select another object, or delete the levels")
    meshes = list(dict.fromkeys(original for original in originals.values() if original.type == "MESH"))
    if not meshes:
        raise Refusal("No mesh is selected: select at least one mesh object")
    return meshes


def plan_levels(tasks, options):
    """Returns for each task its levels, as tasks with a number of faces, or with none where faces are shared out."""
    ratios = parse_ratios(options.ratios)
    scene.set_bounds(tasks, options)
    levels = []
    for task in tasks:
        check_names(task.owner, len(ratios))
        own = task.own_ratio or 1.0
        counts = [max(round(ratio * own * len(task.source.triangles)), 1) for ratio in ratios]
        levels.append(
            [replace(task, size={"faces": n}, name=f"{task.name}_LOD{k}", measures_distance=True) for k, n in enumerate(counts)]
        )
    return levels


def simplify_levels(levels, shares_out, tell):
    """Simplifies all levels; with `shares_out` the faces of each level are first shared out among all objects."""
    if shares_out:
        for tasks in zip(*levels):
            shared = [task for task in tasks if task.own_ratio is None]
            n_faces = sum(task.size["faces"] for task in shared)
            if len(shared) > 1 and n_faces < sum(len(task.source.triangles) for task in shared):
                share_faces(shared, n_faces, lambda done, stage: tell and tell(0.0))
    simplify_tasks([task for tasks in levels for task in tasks], None, tell)


def check_names(original, n_levels):
    """Refuses where another object has a level's name, since engines know levels by their names."""
    group = find_group(original)
    own = {item.name for item in (group, *find_levels(group))} if group else set()
    for name in (f"{original.name}_LODs", *(f"{original.name}_LOD{k}" for k in range(n_levels))):
        if name in bpy.data.objects and name not in own:
            raise Refusal(f"Another object is called {name}: rename or delete it, as the levels need the name")


def make_levels(context, tasks, options):
    """Makes the objects of one original's levels, in place of those of an earlier call, and returns the empty above them."""
    original = tasks[0].owner
    group = make_group(original)
    group[PROPERTY] = 0
    group.id_properties_ui(PROPERTY).update(
        min=-1, max=len(tasks) - 1, description="Visible level of detail; -1 shows the original"
    )
    for number, task in enumerate(tasks):
        task.owner = level = copy_object(original, group, task.name)
        level[LEVEL], level[ERROR] = number, task.largest_error
        group.users_collection[0].objects.link(level)
        if task.result is None and task.applies_modifiers:
            task.result = task.source
        if task.result is not None:
            scene.put_in_place(context, task, options)
        drive_visibility(level, group, f"lod != {number}")
    drive_visibility(original, group, f"0 <= lod < {len(tasks)}")
    return group


def make_group(original):
    """Returns the empty above an original's levels, without levels, where the original is."""
    group = find_group(original)
    if group is None:
        group = bpy.data.objects.new(f"{original.name}_LODs", None)
        group.empty_display_size = 0.1
        group[ORIGINAL] = original
        collection = bpy.data.collections.new(group.name)
        original.users_collection[0].children.link(collection)
        collection.objects.link(group)
    group.name = f"{original.name}_LODs"
    for level in find_levels(group):
        mesh = level.data
        bpy.data.objects.remove(level)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    place_like(group, original)
    return group


def place_like(group, original):
    """Gives an empty the parent and the place of an object, which it follows from then on."""
    group.parent, group.parent_type, group.parent_bone = original.parent, original.parent_type, original.parent_bone
    if original.parent_type not in ("OBJECT", "BONE"):
        # Armatures deform meshes alone.
        group.parent_type = "OBJECT"
    group.matrix_parent_inverse = original.matrix_parent_inverse
    group.matrix_world = original.matrix_world
    if not group.constraints:
        group.constraints.new("COPY_TRANSFORMS").target = original


def copy_object(original, group, name):
    """Returns a copy of an object under an empty, with a mesh of its own; materials and armature are shared."""
    copy = original.copy()
    copy.data = original.data.copy()
    copy.name = copy.data.name = name
    # The original's motion, constraints and drivers act on the copy through the empty.
    copy.animation_data_clear()
    copy.constraints.clear()
    if original.parent_type == "ARMATURE" and not any(modifier.type == "ARMATURE" for modifier in copy.modifiers):
        copy.modifiers.new("Armature", "ARMATURE").object = original.parent
    copy.parent, copy.parent_type = group, "OBJECT"
    copy.matrix_parent_inverse = Matrix.Identity(4)
    copy.delta_location, copy.delta_rotation_euler, copy.delta_scale = (0, 0, 0), (0, 0, 0), (1, 1, 1)
    copy.delta_rotation_quaternion = (1, 0, 0, 0)
    copy.matrix_basis = Matrix.Identity(4)
    return copy


def drive_visibility(item, group, expression):
    """Hides an object in viewport and render where the expression of `lod` is true."""
    for path in ("hide_viewport", "hide_render"):
        item.driver_remove(path)
        driver = item.driver_add(path).driver
        driver.expression = expression
        variable = driver.variables.new()
        variable.name = "lod"
        variable.targets[0].id = group
        variable.targets[0].data_path = f'["{PROPERTY}"]'

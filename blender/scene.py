# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the selected objects as tasks, refusing in one line what cannot be simplified, and puts results in place.
Everything is checked and read before the first mesh changes, so that a refusal loses nothing."""

from contextlib import contextmanager, nullcontext

import bpy
import numpy as np

from . import bake, convert, error_colors, poses
from .job import Refusal
from .simplify import MOST_IMPORTANCE, MOST_PROTECTION, Task

# Modifiers that are bound to vertices.
BOUND_MODIFIERS = ("HOOK", "MESH_DEFORM", "SURFACE_DEFORM", "LAPLACIANDEFORM")


def find_objects(context):
    """Returns the selected mesh objects, one for each mesh."""
    if context.mode != "OBJECT":
        raise Refusal("Simplify works only in Object Mode: switch to Object Mode first")
    objects = [item for item in context.selected_objects if item.type == "MESH"]
    if not objects:
        raise Refusal("No mesh is selected: select at least one mesh object")
    return list({item.data: item for item in reversed(objects)}.values())[::-1]


def check_object(item, applies_modifiers):
    """Refuses an object whose mesh cannot be changed, or would lose something."""
    if item.library or item.override_library or item.data.library or item.data.override_library:
        raise Refusal(f"{item.name} is linked from a library: make it local first")
    if not item.data.polygons:
        raise Refusal(f"{item.name} has no faces")
    if applies_modifiers:
        if item.data.shape_keys:
            raise Refusal(f"{item.name} has shape keys: its modifiers cannot be applied: turn Apply Modifiers off")
        if item.data.users > 1:
            raise Refusal(f"{item.name} shares its mesh with other objects: make it single-user to apply modifiers")
    elif any(modifier.type == "MULTIRES" for modifier in item.modifiers):
        raise Refusal(f"{item.name} has a Multiresolution modifier: apply it first, or turn Apply Modifiers on")


def read_tasks(context, options):
    """Returns a task without a size for each selected mesh."""
    objects = find_objects(context)
    for item in objects:
        check_object(item, options.apply_modifiers)
    for name in (options.importance_group, options.protection_group):
        if name and not any(name in item.vertex_groups for item in objects):
            raise Refusal(f"No selected object has a vertex group named {name}")
    return [read_task(context, item, options) for item in objects]


def read_task(context, item, options):
    """Returns the task of one object, without a size."""
    materials = []
    if options.apply_modifiers:
        with evaluated_mesh(context, item) as mesh:
            source, materials = convert.read_mesh(item, mesh, options.keep_shading), list(mesh.materials)
    else:
        source = convert.read_mesh(item, item.data, options.keep_shading)
    if not np.isfinite(source.positions).all():
        raise Refusal(f"{item.name} has vertices at positions that are not finite")
    if len(source.triangles) == 0:
        raise Refusal(f"{item.name} has no faces after its modifiers are applied")
    return Task(
        owner=item,
        name=item.name,
        materials=materials,
        source=source,
        matrix=np.array(item.matrix_world, np.float32),
        size={},
        importance=read_importance(item, source, options),
        is_welded=options.merge_equal,
        keeps_components=options.keep_components,
        poses=poses.read_poses(context, item, source) if options.bends else [],
        measures_errors=options.error_colors,
    )


def read_importance(item, source, options):
    """Returns the importance of each vertex, n, or `None` without a chosen group."""
    chosen = ((options.importance_group, MOST_IMPORTANCE), (options.protection_group, MOST_PROTECTION))
    factors = [most ** source.groups[item.vertex_groups[name].index] for name, most in chosen if name in item.vertex_groups]
    return np.prod(factors, axis=0).astype(np.float32) if factors else None


@contextmanager
def evaluated_mesh(context, item):
    """Makes the mesh of the modifiers that show in the viewport, all but armatures, for as long as the block runs."""
    armatures = [modifier for modifier in item.modifiers if modifier.type == "ARMATURE" and modifier.show_viewport]
    for modifier in armatures:
        modifier.show_viewport = False
    try:
        graph = context.evaluated_depsgraph_get()
        mesh = bpy.data.meshes.new_from_object(item.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    finally:
        for modifier in armatures:
            modifier.show_viewport = True
    try:
        yield mesh
    finally:
        bpy.data.meshes.remove(mesh)


def measure_diagonal(tasks):
    """Returns the diagonal of the box around all meshes, in units of the scene."""
    points = [task.source.positions @ task.matrix[:3, :3].T + task.matrix[:3, 3] for task in tasks]
    lowest, highest = np.min([p.min(0) for p in points], 0), np.max([p.max(0) for p in points], 0)
    return float(np.linalg.norm(highest - lowest))


def plan_sizes(tasks, options):
    """Sets the bound of each task, or returns the number of faces to share out among them."""
    n_triangles = sum(len(task.source.triangles) for task in tasks)
    if options.size_by == "RATIO":
        return max(round(options.ratio * n_triangles), 1)
    if options.size_by == "FACES":
        return options.faces
    is_percent = options.size_by == "ERROR_PERCENT"
    error = options.error_percent / 100 * measure_diagonal(tasks) if is_percent else options.error_units
    if error <= 0:
        raise Refusal("The error is 0: give a distance above 0")
    for task in tasks:
        if task.scale <= 0:
            raise Refusal(f"{task.name} has a scale of 0: set another scale")
        task.size = {"error": error / task.scale}
    return None


def put_in_place(context, task, options):
    """Writes a result into its object's mesh, keeping materials that modifiers brought, and bakes them to a new one if wanted."""
    item = task.owner
    with bake.copied_original(context, item) if options.bake else nullcontext() as original:
        convert.write_mesh(item, task.result)
        for material in task.materials[len(item.data.materials) :]:
            item.data.materials.append(material)
        error_colors.write_largest_error(item, task.largest_error if task.measures_errors else None)
        if options.apply_modifiers:
            for modifier in [m for m in item.modifiers if m.type != "ARMATURE" and m.show_viewport]:
                item.modifiers.remove(modifier)
        if options.bake:
            bake.bake_material(context, original, item, task.source, options.bake_size)


def find_bound_modifiers(item):
    """Returns the names of modifiers that have to be bound again."""
    return [modifier.name for modifier in item.modifiers if modifier.type in BOUND_MODIFIERS]

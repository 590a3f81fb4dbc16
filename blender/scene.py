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
# Modifiers that are never applied: armatures, and those of a simulation.
KEPT_MODIFIERS = ("ARMATURE", "CLOTH", "COLLISION", "DYNAMIC_PAINT", "FLUID", "PARTICLE_SYSTEM", "SOFT_BODY", "SURFACE")
# Objects with a surface that is no mesh yet.
CONVERTIBLE = {"FONT": "text", "CURVE": "curve", "SURFACE": "surface", "META": "metaball"}


def find_objects(context, with_empties=False):
    """Returns the selected mesh objects, and empties if wanted."""
    if context.mode != "OBJECT":
        raise Refusal("Simplify works only in Object Mode: switch to Object Mode first")
    for item in context.selected_objects:
        if item.type in CONVERTIBLE:
            kind = CONVERTIBLE[item.type]
            raise Refusal(f"{item.name} is a {kind}, not a mesh: convert it (Object > Convert > Mesh) or deselect it")
    types = ("MESH", "EMPTY") if with_empties else ("MESH",)
    objects = [item for item in context.selected_objects if item.type in types]
    if not objects:
        raise Refusal("No mesh is selected: select at least one mesh object")
    return objects


def list_single(objects):
    """Returns one object for each mesh."""
    return list({item.data: item for item in reversed(objects)}.values())[::-1]


def check_object(item, applies_modifiers):
    """Refuses an object whose mesh cannot be changed, or would lose something."""
    if item.library or item.override_library or item.data.library or item.data.override_library:
        raise Refusal(f"{item.name} is linked from a library: make it local first")
    if not item.data.polygons and not (applies_modifiers and find_applicable(item)):
        raise Refusal(f"{item.name} has no faces")
    if any(modifier.type == "MULTIRES" for modifier in item.modifiers) and (not applies_modifiers or item.data.shape_keys):
        raise Refusal(f"{item.name} has a Multiresolution modifier: apply it first, or turn Apply Modifiers on")


def find_applicable(item):
    """Returns the modifiers of an object that Apply Modifiers applies."""
    return [modifier for modifier in item.modifiers if modifier.show_viewport and modifier.type not in KEPT_MODIFIERS]


def read_tasks(context, options, objects, is_copied=False):
    """Returns a task without a size for each object; `is_copied` says that results go to copies, with meshes of their own."""
    for item in objects:
        check_object(item, options.apply_modifiers)
    for name in (options.importance_group, options.protection_group):
        if name and not any(name in item.vertex_groups for item in objects):
            raise Refusal(f"No selected object has a vertex group named {name}")
    with shown(context, objects):
        return [read_task(context, item, options, is_copied) for item in objects]


def read_task(context, item, options, is_copied):
    """Returns the task of one object, without a size."""
    reason = explain_kept(item, options, is_copied) if find_applicable(item) else ""
    applies = bool(find_applicable(item)) and not reason
    materials, note = [], ""
    if applies:
        with evaluated_mesh(context, item) as mesh:
            source, materials = convert.read_mesh(item, mesh, options.keep_shading), list(mesh.materials)
    else:
        source = convert.read_mesh(item, item.data, options.keep_shading)
        note = note_unseen(context, item, len(source.triangles), reason) if reason else ""
    if not np.isfinite(source.positions).all():
        raise Refusal(f"{item.name} has vertices at positions that are not finite")
    if len(source.triangles) == 0:
        raise Refusal(f"{item.name} has no faces after its modifiers are applied")
    bends = options.bends and poses.will_bend(item, source)
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
        bends=bends,
        poses=poses.read_poses(context, item, source) if bends else [],
        measures_errors=options.error_colors,
        applies_modifiers=applies,
        own_ratio=item.neural_mesh.ratio if item.neural_mesh.has_ratio else None,
        note=note,
    )


def explain_kept(item, options, is_copied):
    """Returns why the modifiers of an object are not applied; empty if they are."""
    if not options.apply_modifiers:
        return "Apply Modifiers is off"
    if item.data.shape_keys:
        return "modifiers cannot be applied to a mesh with shape keys"
    if item.data.users > 1 and not is_copied:
        return "modifiers cannot be applied to a mesh of several objects"
    return ""


def note_unseen(context, item, n_triangles, reason):
    """Returns a line where modifiers that stay show another number of triangles than the size counts."""
    with evaluated_mesh(context, item) as mesh:
        n_seen = len(mesh.loops) - 2 * len(mesh.polygons)
    if n_seen == n_triangles:
        return ""
    return f"{item.name}: the size counts {n_triangles:,} triangles, not the {n_seen:,} that its modifiers show, as {reason}"


def read_importance(item, source, options):
    """Returns the importance of each vertex, n, or `None` without a chosen group."""
    chosen = ((options.importance_group, MOST_IMPORTANCE), (options.protection_group, MOST_PROTECTION))
    factors = [most ** source.groups[item.vertex_groups[name].index] for name, most in chosen if name in item.vertex_groups]
    return np.prod(factors, axis=0).astype(np.float32) if factors else None


@contextmanager
def shown(context, objects):
    """Shows objects that are hidden, also by drivers, for as long as the block runs."""
    states = []
    for item in objects:
        drivers = item.animation_data.drivers if item.animation_data else ()
        hiding = [driver for driver in drivers if driver.data_path.startswith("hide_") and not driver.mute]
        states.append((item, item.hide_viewport, item.hide_render, item.hide_get(), item.hide_select, hiding))
        for driver in hiding:
            driver.mute = True
        item.hide_viewport = item.hide_render = item.hide_select = False
        item.hide_set(False)
    context.view_layer.update()
    try:
        yield
    finally:
        for item, hides_viewport, hides_render, is_hidden, hides_select, hiding in states:
            item.hide_set(is_hidden)
            item.hide_viewport, item.hide_render, item.hide_select = hides_viewport, hides_render, hides_select
            for driver in hiding:
                driver.mute = False
        context.view_layer.update()


@contextmanager
def evaluated_mesh(context, item):
    """Makes the mesh of the modifiers that Apply Modifiers applies, for as long as the block runs."""
    kept = [modifier for modifier in item.modifiers if modifier.type in KEPT_MODIFIERS and modifier.show_viewport]
    for modifier in kept:
        modifier.show_viewport = False
    try:
        graph = context.evaluated_depsgraph_get()
        mesh = bpy.data.meshes.new_from_object(item.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    finally:
        for modifier in kept:
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
    """Sets bounds, and sizes of tasks that have one of their own; returns the number of faces to share out among the others."""
    set_bounds(tasks, options)
    if options.size_by in ("RATIO", "FACES"):
        own = [task for task in tasks if task.own_ratio is not None]
        for task in own:
            task.size = {"faces": max(round(task.own_ratio * len(task.source.triangles)), 1)}
        n_triangles = sum(len(task.source.triangles) for task in tasks if task.own_ratio is None)
        if options.size_by == "RATIO":
            return max(round(options.ratio * n_triangles), 1) if n_triangles else None
        return max(options.faces - sum(task.size["faces"] for task in own), 1) if n_triangles else None
    is_percent = options.size_by == "ERROR_PERCENT"
    error = options.error_percent / 100 * measure_diagonal(tasks) if is_percent else options.error_units
    if error <= 0:
        raise Refusal("The error is 0: give a distance above 0")
    for task in tasks:
        task.size = {"error": error / check_scale(task)}
    return None


def set_bounds(tasks, options):
    """Sets the largest distance that a number of faces may cost."""
    bound = options.bound_percent / 100 * measure_diagonal(tasks)
    for task in tasks:
        task.bound = bound / check_scale(task) if bound > 0 else 0.0


def check_scale(task):
    """Returns the scale of a task; refuses one that its transform scales to nothing, where no distance can be kept."""
    if task.scale <= 0:
        raise Refusal(f"{task.name} has a scale of 0: set another scale")
    return task.scale


def put_in_place(context, task, options):
    """Writes a result into its object's mesh, keeping materials that modifiers brought, and bakes them to a new one if wanted."""
    item = task.owner
    with bake.copied_original(context, item) if options.bake else nullcontext() as original:
        convert.write_mesh(item, task.result)
        for material in task.materials[len(item.data.materials) :]:
            item.data.materials.append(material)
        error_colors.write_largest_error(item, task.largest_color_error if task.measures_errors else None)
        if task.applies_modifiers:
            for modifier in find_applicable(item):
                item.modifiers.remove(modifier)
        if options.bake:
            bake.bake_material(context, original, item, task.source, options.bake_size)


def find_bound_modifiers(item):
    """Returns the names of modifiers that have to be bound again."""
    return [modifier.name for modifier in item.modifiers if modifier.type in BOUND_MODIFIERS]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the panel in the sidebar of the 3-D view.
It shows the settings of the scene and hands them to the operators."""

from bpy.types import Panel

from . import error_colors, lods, preview
from .operators import OBJECT_OT_neural_mesh_lods, OBJECT_OT_neural_mesh_preview, OBJECT_OT_neural_mesh_simplify
from .settings import Carrying, Levels, Sizing, copy_settings

# Property that holds the size, by the way it is given.
SIZE_PROPERTIES = {"RATIO": "ratio", "FACES": "faces", "ERROR_PERCENT": "error_percent", "ERROR_UNITS": "error_units"}

# Rows of the table, at most.
MOST_ROWS = 20


class VIEW3D_PT_neural_mesh(Panel):
    """Panel of the extension."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Neural Mesh"
    bl_label = "Neural Mesh"

    def draw(self, context):
        """Draws settings, buttons and the legend."""
        settings, active = context.scene.neural_mesh, context.active_object
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "size_by")
        layout.prop(settings, SIZE_PROPERTIES[settings.size_by])
        operator = layout.operator(OBJECT_OT_neural_mesh_simplify.bl_idname, icon="MOD_DECIM")
        copy_settings(settings, operator, Carrying, Sizing)
        is_on = preview.current is not None
        layout.operator(OBJECT_OT_neural_mesh_preview.bl_idname, icon="HIDE_OFF" if is_on else "HIDE_ON", depress=is_on)
        if is_on:
            layout.label(text=preview.current.message or "Working")
        layout.prop(settings, "bound_percent")
        draw_table(layout, context)
        for name in ("ratios", "share_out", "engine"):
            layout.prop(settings, name)
        if settings.engine != "NONE":
            for name in ("folder", "replace_files"):
                layout.prop(settings, name)
        if settings.engine == "GODOT":
            layout.prop(settings, "field_of_view")
        operator = layout.operator(OBJECT_OT_neural_mesh_lods.bl_idname, icon="OUTLINER_COLLECTION")
        copy_settings(settings, operator, Carrying, Levels)
        if active is not None and active.type == "MESH":
            for name in ("importance_group", "protection_group"):
                layout.prop_search(settings, name, active, "vertex_groups")
        for name in ("apply_modifiers", "merge_equal", "keep_components", "keep_shading", "bends", "error_colors", "bake"):
            layout.prop(settings, name)
        if settings.bake:
            layout.prop(settings, "bake_size")
        if active is not None:
            draw_active(layout, active)


def draw_table(layout, context):
    """Draws a row for each selected mesh: its triangles, before and now, and its own ratio; and a row for each of its levels."""
    objects = list(dict.fromkeys(lods.find_original(item) for item in context.selected_objects))
    objects = [item for item in objects if item is not None and item.type == "MESH"]
    graph = context.evaluated_depsgraph_get() if objects else None
    for item in objects[:MOST_ROWS]:
        now, before = count_triangles(item.evaluated_get(graph).data), item.neural_mesh.n_before
        row = layout.row(align=True)
        row.label(text=f"{item.name}: {before:,} to {now:,}" if before > now else f"{item.name}: {now:,}")
        row.prop(item.neural_mesh, "has_ratio", text="")
        column = row.column()
        column.active = item.neural_mesh.has_ratio
        column.prop(item.neural_mesh, "ratio", text="")
        group = lods.find_group(item)
        for level in lods.find_levels(group) if group is not None else ():
            layout.label(text=f"    LOD{level[lods.LEVEL]}: {count_triangles(level.data):,}, error {level.get(lods.ERROR, 0):.3g}")
    if len(objects) > MOST_ROWS:
        layout.label(text=f"and {len(objects) - MOST_ROWS} more")


def count_triangles(mesh):
    """Returns the number of triangles of a mesh's polygons."""
    return len(mesh.loops) - 2 * len(mesh.polygons)


def draw_active(layout, active):
    """Draws the level of detail and the legend of the error colours of an object."""
    group = lods.find_group(active)
    if group is not None and lods.PROPERTY in group:
        layout.prop(group, f'["{lods.PROPERTY}"]', text="Level of Detail")
    if error_colors.PROPERTY in active:
        layout.label(text=f"Error: blue 0, red {active[error_colors.PROPERTY]:.4g}", icon="COLOR")


CLASSES = (VIEW3D_PT_neural_mesh,)

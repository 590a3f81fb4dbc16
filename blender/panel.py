# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the panel in the sidebar of the 3-D view.
It shows the settings of the scene and hands them to the operators."""

from bpy.types import Panel

from . import error_colors, lods, preview
from .operators import OBJECT_OT_neural_mesh_lods, OBJECT_OT_neural_mesh_preview, OBJECT_OT_neural_mesh_simplify
from .settings import Carrying, Levels, Sizing, copy_settings

# Property that holds the size, by the way it is given.
SIZE_PROPERTIES = {"RATIO": "ratio", "FACES": "faces", "ERROR_PERCENT": "error_percent", "ERROR_UNITS": "error_units"}


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
        layout.prop(settings, "ratios")
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


def draw_active(layout, active):
    """Draws the level of detail and the legend of the error colours of an object."""
    original = active if lods.PROPERTY in active else active.parent
    if original is not None and lods.PROPERTY in original:
        layout.prop(original, f'["{lods.PROPERTY}"]', text="Level of Detail")
    if error_colors.PROPERTY in active:
        layout.label(text=f"Error: blue 0, red {active[error_colors.PROPERTY]:.4g}", icon="COLOR")


CLASSES = (VIEW3D_PT_neural_mesh,)

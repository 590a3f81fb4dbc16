# SPDX-License-Identifier: GPL-3.0-or-later
"""Declares the settings, once for the panel, which stores them with the scene, and for the operators.
Each property says its unit; an operator that is called from a script has the same names."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

SIZES = (
    ("RATIO", "Ratio", "Share of the triangles to keep"),
    ("FACES", "Faces", "Number of triangles to keep, for all selected objects together"),
    ("ERROR_PERCENT", "Error in %", "Fewest triangles within a proved distance, in percent of the diagonal of the selection"),
    ("ERROR_UNITS", "Error", "Fewest triangles within a proved distance, in units of the scene"),
)

ENGINES = (
    ("NONE", "Objects Only", "Make the objects, and write no file"),
    ("UNITY", "Unity", "NAME.fbx with NAME_LOD0, NAME_LOD1 and so on under one parent, of which Unity makes a LOD Group"),
    ("UNREAL", "Unreal", "NAME.fbx with a LOD group, of which Unreal imports the levels of one mesh"),
    ("GODOT", "Godot", "NAME.glb, and NAME_LODs.gd, an import script that sets the visibility range of each level"),
    ("GLTF", "glTF", "NAME.glb with all levels (MSFT_lod)"),
)


class Carrying:
    """Properties of everything that makes lighter meshes."""

    importance_group: StringProperty(name="Importance", description="Vertex group whose vertices get up to ten times the weight")
    protection_group: StringProperty(name="Protection", description="Vertex group whose vertices get up to a thousand times the weight")
    apply_modifiers: BoolProperty(
        name="Apply Modifiers",
        description="Apply modifiers before simplifying, so that the size is that of what is seen, except armatures and simulations; "
        "otherwise the simplified mesh keeps the modifiers",
        default=True,
    )
    merge_equal: BoolProperty(
        name="Merge Equal Vertices",
        description="Merge vertices that have equal positions, shape keys and weights",
        default=True,
    )
    keep_components: BoolProperty(
        name="Keep All Components",
        description="Keep all components, even very small ones, unless the size is out of reach with them",
        default=True,
    )
    keep_shading: BoolProperty(
        name="Keep Shading",
        description="Set custom normals that shade smooth faces like the original; otherwise Blender computes normals from the simplified mesh",
        default=True,
    )
    bake: BoolProperty(
        name="Bake Material",
        description="Bake color, roughness, metalness and normals of the original into the textures of a new material",
    )
    bake_size: IntProperty(name="Texture Size", description="Pixels on each side of baked textures", default=1024, min=16, max=16384)
    bends: BoolProperty(
        name="Will Bend",
        description="Stay close to the original in shape keys and poses of the armature, too, where a mesh has these",
        default=True,
    )
    bound_percent: FloatProperty(
        name="Bound",
        description="Largest distance that a number of triangles may cost, in percent of the diagonal of the selection; 0 for none",
        default=0.0,
        min=0.0,
        max=100.0,
        precision=3,
    )
    error_colors: BoolProperty(
        name="Error Colors", description="Color each vertex by its distance to the original, from blue to red"
    )


class Sizing:
    """Properties of one size."""

    size_by: EnumProperty(name="Size", items=SIZES, default="RATIO")
    ratio: FloatProperty(
        name="Ratio", description="Share of the triangles to keep", default=0.5, min=0.0001, max=1.0, precision=3
    )
    faces: IntProperty(name="Faces", description="Number of triangles to keep", default=5000, min=1)
    error_percent: FloatProperty(
        name="Error", description="Largest distance in percent of the diagonal", default=0.5, min=0.0001, max=100.0, precision=3
    )
    error_units: FloatProperty(
        name="Error", description="Largest distance in units of the scene", default=0.01, min=0.0, precision=5, unit="LENGTH"
    )


class Levels:
    """Properties of levels of detail."""

    ratios: StringProperty(
        name="Ratios", description="Shares of the triangles, one for each level, separated by commas", default="1, 0.5, 0.25, 0.1"
    )
    share_out: BoolProperty(
        name="Share Out",
        description="Share the triangles of each level out among all selected objects: meshes with more detail get more",
    )
    engine: EnumProperty(name="Engine", items=ENGINES, default="NONE")
    folder: StringProperty(name="Folder", description="Folder of the files; // is that of the .blend file", default="//", subtype="DIR_PATH")
    replace_files: BoolProperty(
        name="Replace Files", description="Also replace files that were not written by this button, such as NAME.fbx in the folder"
    )
    field_of_view: FloatProperty(
        name="Field of View",
        description="Vertical angle of the camera for which distances of levels are chosen",
        default=1.0472,
        min=0.02,
        max=3.0,
        subtype="ANGLE",
    )


class NeuralMeshSettings(Carrying, Sizing, Levels, PropertyGroup):
    """Settings of the panel, kept with the scene."""


class NeuralMeshObject(PropertyGroup):
    """Settings of one object."""

    has_ratio: BoolProperty(name="Own Ratio", description="Give this object its own share of triangles; a factor on the ratios of levels")
    ratio: FloatProperty(
        name="Ratio", description="Share of the triangles to keep", default=0.5, min=0.0001, max=1.0, precision=3
    )
    n_before: IntProperty(name="Before", description="Number of triangles before the last simplification")


def copy_settings(settings, operator_properties, *groups):
    """Copies the properties of these groups from the panel's settings to an operator."""
    for group in groups:
        for name in group.__annotations__:
            setattr(operator_properties, name, getattr(settings, name))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the zip as a user does and simplifies a mesh with it.
The wheel has to come from the zip: the interpreter must not have `neural_mesh` otherwise."""

import sys

import bpy
# Found on the path that `bpy` sets.
import addon_utils

bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("bl_pkg")
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
bpy.ops.mesh.primitive_monkey_add()
assert bpy.ops.object.neural_mesh_simplify(ratio=0.6) == {"FINISHED"}
assert abs(len(bpy.context.object.data.polygons) - 581) <= 1
addon_utils.disable("bl_ext.user_default.neural_mesh")
print("the zip installs")

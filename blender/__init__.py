# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the extension: a panel in the sidebar of the 3-D view, and its operators.
The simplifier itself is the Python package `neural_mesh`, which the extension brings as a wheel."""

import bpy

from . import operators, panel, preview, settings

# Handlers of events that may restore copies of an ended preview.
HANDLERS = ("undo_post", "redo_post", "load_post")
CLASSES = (settings.NeuralMeshSettings, settings.NeuralMeshObject, *operators.CLASSES, *panel.CLASSES)


def register():
    """Registers all classes, and the settings of each scene and object."""
    for item in CLASSES:
        bpy.utils.register_class(item)
    bpy.types.Scene.neural_mesh = bpy.props.PointerProperty(type=settings.NeuralMeshSettings)
    bpy.types.Object.neural_mesh = bpy.props.PointerProperty(type=settings.NeuralMeshObject)
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(preview.remove_orphans)


def unregister():
    """Removes what `register` added."""
    preview.end()
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).remove(preview.remove_orphans)
    del bpy.types.Scene.neural_mesh, bpy.types.Object.neural_mesh
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours the vertices of a simplified mesh by their distance from the original, from blue to red.
The largest distance is stored as a custom property, which the panel shows as the legend."""

import numpy as np
from mathutils.bvhtree import BVHTree

from . import convert

ATTRIBUTE = "neural_mesh_error"
PROPERTY = "neural_mesh_error_max"
# Colours along the scale: blue, cyan, green, yellow, red.
SCALE = np.array([[0, 0, 1], [0, 1, 1], [0, 1, 0], [1, 1, 0], [1, 0, 0]], np.float32)


def measure_errors(original, result):
    """Returns the distance of each vertex of a result from the original's surface, in units of the mesh."""
    tree = BVHTree.FromPolygons(original.positions.tolist(), original.triangles.tolist(), all_triangles=True)
    return np.array([tree.find_nearest(position)[3] for position in result.positions.tolist()], np.float32)


def color_errors(errors, largest):
    """Returns the colour attribute of distances, red where they are the largest."""
    shares = errors / largest if largest > 0 else np.zeros_like(errors)
    stops = np.linspace(0, 1, len(SCALE))
    channels = [np.interp(shares, stops, SCALE[:, channel]) for channel in range(3)]
    colors = np.stack([*channels, np.ones_like(shares)], axis=1).astype(np.float32)
    return convert.Layer(ATTRIBUTE, "POINT", "FLOAT_COLOR", colors)


def write_largest_error(owner, largest):
    """Sets the largest distance, in units of the scene, as a custom property of the object; removes it where there is none."""
    if largest is None:
        owner.pop(PROPERTY, None)
        return
    owner[PROPERTY] = largest
    owner.data.attributes.active_color_name = ATTRIBUTE

# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries shape keys, vertex groups and attributes from an original to its simplified mesh by the map of corners.
Each vertex of the result has a place on a triangle of the original, whose values are blended there."""

from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import numpy as np

# Face attributes whose borders the simplifier keeps: the result's faces have them exactly.
BORDER_ATTRIBUTES = ("material_index", "sharp_face")


@dataclass(frozen=True)
class Places:
    """The closest triangles of the original and weights on them, for corners, vertices and faces of the result."""

    triangles: np.ndarray
    """Triangle of the original for each corner of the result, m x 3."""
    weights: np.ndarray
    """Weights of the corners of that triangle, m x 3 x 3."""
    vertex_corners: np.ndarray
    """One corner of the result for each of its vertices, n."""
    faces: np.ndarray
    """Triangle of the original for each triangle of the result, m."""


def find_vertex_corners(light):
    """Returns one corner of the result for each of its vertices."""
    faces = np.asarray(light.faces)
    vertex_corners = np.zeros(len(light.vertices), np.int64)
    vertex_corners[faces.ravel()] = np.arange(faces.size)
    return vertex_corners


def find_places(source, light, clean):
    """Returns the places of a simplified mesh; `clean` are the triangles of the original that were not cleaned away."""
    triangles = clean[light.map.corner_faces]
    faces = np.asarray(light.faces)
    # A face lies on the triangle, of those below its corners, whose middle is nearest.
    middles = source.positions[source.triangles[triangles]].mean(2)
    centers = np.asarray(light.vertices)[faces].mean(1, keepdims=True)
    nearest = ((middles - centers) ** 2).sum(2).argmin(1)
    face_triangles = np.take_along_axis(triangles, nearest[:, None], 1)[:, 0]
    return Places(triangles, light.map.corner_weights, find_vertex_corners(light), face_triangles)


def blend_at_vertices(source, places, values):
    """Returns values of the original's vertices at the vertices of the result, n x k."""
    triangles = places.triangles.ravel()[places.vertex_corners]
    weights = places.weights.reshape(-1, 3)[places.vertex_corners]
    return (values[source.triangles[triangles]] * weights[..., None]).sum(1, dtype=np.float32)


def pick_at_corners(places, rows):
    """Returns for each corner of the result the heaviest corner's row of the triangle it lies on; `rows` are m x 3."""
    return rows[places.triangles, places.weights.argmax(2)].ravel()


def carry_keys(source, places, positions, fitted):
    """Returns the shape keys of the result: its positions, moved by `fitted` offsets, or else as the original moves at the same places."""
    offsets = lambda number, key: fitted[number] if number in fitted else blend_at_vertices(source, places, key - source.positions)
    return [positions + offsets(number, key) for number, key in enumerate(source.keys)]


def carry_groups(source, places):
    """Returns the weights of the vertex groups at the vertices of the result."""
    return [blend_at_vertices(source, places, weights[:, None])[:, 0] for weights in source.groups]


def carry_values(source, places, layer):
    """Returns the values of an attribute that the simplifier itself did not carry."""
    if layer.domain == "FACE":
        return layer.values[places.faces]
    if layer.domain == "POINT" and layer.is_blended:
        return blend_at_vertices(source, places, layer.values)
    rows = source.triangles if layer.domain == "POINT" else np.arange(source.triangles.size).reshape(-1, 3)
    picked = pick_at_corners(places, rows)
    return layer.values[picked[places.vertex_corners] if layer.domain == "POINT" else picked]


def read_keys(mesh):
    """Returns the positions of each shape key, n x 3."""
    if mesh.shape_keys is None:
        return []
    keys = []
    for block in mesh.shape_keys.key_blocks:
        positions = np.empty(3 * len(mesh.vertices), np.float32)
        block.data.foreach_get("co", positions)
        keys.append(positions.reshape(-1, 3))
    return keys


def read_groups(owner, mesh):
    """Returns the weights of each vertex group, n; a vertex outside of a group weighs 0 there."""
    weights = np.zeros((len(owner.vertex_groups), len(mesh.vertices)), np.float32)
    if len(weights) == 0:
        return []
    for vertex in mesh.vertices:
        for element in vertex.groups:
            # Modifiers may bring groups that the object has no names for.
            if element.group < len(weights):
                weights[element.group, vertex.index] = element.weight
    return list(weights)


@contextmanager
def kept_group_names(owner):
    """Restores names, order and locks of the vertex groups after a change that loses them."""
    active = owner.vertex_groups.active_index
    groups = [(group.name, group.lock_weight) for group in owner.vertex_groups]
    yield
    for name, is_locked in groups:
        owner.vertex_groups.new(name=name).lock_weight = is_locked
    if groups:
        owner.vertex_groups.active_index = active


def write_keys_and_groups(mesh, keys, groups):
    """Sets shape keys and vertex groups of a mesh that has only vertices so far."""
    if not keys and not groups:
        return
    # A round trip through a BMesh gives each key block as many points as the mesh has vertices now.
    form = bmesh.new()
    form.from_mesh(mesh)
    form.verts.ensure_lookup_table()
    deform = form.verts.layers.deform.verify()
    for index, weights in enumerate(groups):
        members = np.flatnonzero(weights > 0)
        for vertex, weight in zip(members.tolist(), weights[members].tolist()):
            form.verts[vertex][deform][index] = weight
    form.to_mesh(mesh)
    form.free()
    for block, positions in zip(mesh.shape_keys.key_blocks if keys else (), keys):
        block.data.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())

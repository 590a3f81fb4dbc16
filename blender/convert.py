# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts a Blender mesh to numpy arrays and writes simplified arrays into it again.
The mesh is changed in place, so that its materials, drivers, animation and users stay attached."""

from dataclasses import dataclass, field

import numpy as np

from . import carry

# Attributes that Blender derives from others, or that this extension writes.
OWN_ATTRIBUTES = ("position", "sharp_edge", "custom_normal", "neural_mesh_error")
# Property, width, dtype and whether values may be blended, by the type of an attribute.
TYPES = {
    "FLOAT": ("value", 1, np.float32, True),
    "FLOAT_VECTOR": ("vector", 3, np.float32, True),
    "FLOAT2": ("vector", 2, np.float32, True),
    "FLOAT_COLOR": ("color", 4, np.float32, True),
    "BYTE_COLOR": ("color_srgb", 4, np.float32, True),
    "QUATERNION": ("value", 4, np.float32, False),
    "FLOAT4X4": ("value", 16, np.float32, False),
    "INT": ("value", 1, np.int32, False),
    "INT8": ("value", 1, np.int32, False),
    "INT32_2D": ("value", 2, np.int32, False),
    "BOOLEAN": ("value", 1, np.bool_, False),
}
# Cosine between two normals of a vertex below which the edge between them is sharp: 2.6 degrees.
SHARP_COSINE = 0.999
# Difference of texture coordinates across a seam: a tenth of a texel of 1024.
SEAM_DIFFERENCE = 1e-4


@dataclass(frozen=True)
class Layer:
    """An attribute of a mesh: its name, domain, type and values, a row for each element."""

    name: str
    domain: str
    type: str
    values: np.ndarray

    @property
    def is_blended(self):
        """Returns whether values may be averaged."""
        return TYPES[self.type][3]

    @property
    def is_color(self):
        """Returns whether the attribute is a colour."""
        return self.type in ("FLOAT_COLOR", "BYTE_COLOR")


@dataclass
class MeshArrays:
    """A mesh as arrays; rows of `layers` are those of vertices, corners of triangles, or triangles."""

    positions: np.ndarray
    """Positions of the vertices, n x 3, `float32`; those of the reference key where there are shape keys."""
    triangles: np.ndarray
    """Vertices of the triangles, m x 3."""
    layers: list = field(default_factory=list)
    keys: list = field(default_factory=list)
    """Positions of each shape key, n x 3."""
    groups: list = field(default_factory=list)
    """Weights of each vertex group, n."""
    normals: np.ndarray | None = None
    """Normals of the corners, m x 3 x 3, where they are more than those of smooth or flat faces."""
    has_custom_normals: bool = False
    has_seams: bool = False


def read_mesh(owner, mesh, keeps_shading=False):
    """Returns the arrays of a mesh, its polygons as triangles; `owner` is the object that has its vertex groups.

    With `keeps_shading` the normals of smooth faces become custom normals, so that the result is shaded as the original.
    """
    n_corners = len(mesh.loops)
    vertices = get(mesh.attributes[".corner_vert"].data, "value", np.int32, n_corners)
    corners, polygons = read_triangles(mesh)
    positions = get(mesh.attributes["position"].data, "vector", np.float32, 3 * len(mesh.vertices)).reshape(-1, 3)
    keys = carry.read_keys(mesh)
    if keys:
        positions = keys[list(mesh.shape_keys.key_blocks).index(mesh.shape_keys.reference_key)]
    is_shaded = keeps_shading and mesh.normals_domain != "FACE"
    normals = None
    if mesh.has_custom_normals or mesh.normals_domain == "CORNER":
        normals = get(mesh.corner_normals, "vector", np.float32, 3 * n_corners).reshape(-1, 3)[corners]
    elif is_shaded:
        normals = get(mesh.vertex_normals, "vector", np.float32, 3 * len(mesh.vertices)).reshape(-1, 3)[vertices[corners]]
    return MeshArrays(
        positions=positions,
        triangles=vertices[corners].reshape(-1, 3),
        layers=read_layers(mesh, corners, polygons),
        keys=keys,
        groups=carry.read_groups(owner, mesh),
        normals=None if normals is None else normals.reshape(-1, 3, 3),
        has_custom_normals=mesh.has_custom_normals or is_shaded,
        has_seams=has_seams(mesh),
    )


def read_triangles(mesh):
    """Returns the corners of the triangles of all polygons, and the polygon of each triangle; slices where every polygon is a triangle."""
    n_polygons, n_corners = len(mesh.polygons), len(mesh.loops)
    # No polygon has fewer than three corners.
    if n_corners == 3 * n_polygons:
        return slice(None), slice(None)
    mesh.calc_loop_triangles()
    n_triangles = len(mesh.loop_triangles)
    corners = get(mesh.loop_triangles, "loops", np.int32, 3 * n_triangles)
    return corners, get(mesh.loop_triangle_polygons, "value", np.int32, n_triangles)


def has_seams(mesh):
    """Returns whether a mesh with texture coordinates has edges that are marked as seams."""
    marks = mesh.attributes.get(".uv_seam") or mesh.attributes.get("uv_seam")
    return bool(mesh.uv_layers and marks and get(marks.data, "value", np.bool_, len(mesh.edges)).any())


def get(collection, name, dtype, size):
    """Returns a property of all elements of a collection as a flat array."""
    values = np.empty(size, dtype)
    collection.foreach_get(name, values)
    return values


def read_layers(mesh, corners, polygons):
    """Returns the attributes of vertices, corners and faces, with a row for each corner or triangle."""
    rows = {"POINT": slice(None), "CORNER": corners, "FACE": polygons}
    layers = []
    for attribute in mesh.attributes:
        name, domain, kind = attribute.name, attribute.domain, attribute.data_type
        if name in OWN_ATTRIBUTES or name.startswith(".") or domain not in rows or kind not in TYPES:
            continue
        prop, width, dtype, _ = TYPES[kind]
        values = get(attribute.data, prop, dtype, width * len(attribute.data)).reshape(-1, width)
        layers.append(Layer(name, domain, kind, values[rows[domain]]))
    return layers


def write_mesh(owner, arrays):
    """Replaces the geometry of an object's mesh and all that its vertices, corners and faces carry."""
    mesh = owner.data
    active = read_active(mesh)
    # Vertex groups belong to the geometry and are lost with it; materials and shape keys are not.
    with carry.kept_group_names(owner):
        mesh.clear_geometry()
    mesh.vertices.add(len(arrays.positions))
    mesh.vertices.foreach_set("co", arrays.positions.ravel())
    carry.write_keys_and_groups(mesh, arrays.keys, arrays.groups)
    n_triangles = len(arrays.triangles)
    mesh.loops.add(3 * n_triangles)
    mesh.polygons.add(n_triangles)
    mesh.loops.foreach_set("vertex_index", arrays.triangles.astype(np.int32).ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * n_triangles, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    for layer in arrays.layers:
        write_layer(mesh, layer)
    write_active(mesh, active)
    write_edges(mesh, arrays)
    mesh.update()
    mesh.validate()


def write_layer(mesh, layer):
    """Adds an attribute with its values."""
    attribute = mesh.attributes.get(layer.name)
    if attribute is None:
        attribute = mesh.attributes.new(layer.name, layer.type, layer.domain)
    prop, _, dtype, _ = TYPES[layer.type]
    attribute.data.foreach_set(prop, np.ascontiguousarray(layer.values, dtype=dtype).ravel())


def read_active(mesh):
    """Returns the names of the active and rendered texture coordinates and colours."""
    uv = mesh.uv_layers
    return {
        "uv": uv.active.name if uv.active else "",
        "rendered_uv": next((layer.name for layer in uv if layer.active_render), ""),
        "color": mesh.attributes.active_color_name,
        "rendered_color": mesh.attributes.default_color_name,
    }


def write_active(mesh, active):
    """Makes the named texture coordinates and colours active again."""
    if active["uv"] in mesh.uv_layers:
        mesh.uv_layers.active = mesh.uv_layers[active["uv"]]
    if active["rendered_uv"] in mesh.uv_layers:
        mesh.uv_layers[active["rendered_uv"]].active_render = True
    mesh.attributes.active_color_name = active["color"] or ""
    mesh.attributes.default_color_name = active["rendered_color"] or ""


def write_edges(mesh, arrays):
    """Sets normals and sharp edges again, and marks seams along borders of charts."""
    if arrays.has_custom_normals:
        set_custom_normals(mesh, arrays)
    elif arrays.normals is not None:
        differ = lambda a, b: (a * b).sum(1) < SHARP_COSINE
        sharp = find_split_edges(mesh, arrays.normals.reshape(-1, 3), differ)
        write_layer(mesh, Layer("sharp_edge", "EDGE", "BOOLEAN", sharp))
    uv = next((layer for layer in arrays.layers if layer.domain == "CORNER" and layer.type == "FLOAT2"), None)
    if arrays.has_seams and uv is not None:
        differ = lambda a, b: np.abs(a - b).max(1) > SEAM_DIFFERENCE
        mesh.edges.foreach_set("use_seam", find_split_edges(mesh, uv.values.reshape(-1, 2), differ))


def set_custom_normals(mesh, arrays):
    """Sets custom normals: of vertices, which is several times as fast, where no vertex has two."""
    normals = np.ascontiguousarray(arrays.normals, np.float32).reshape(-1, 3)
    corners = arrays.triangles.ravel()
    of_vertices = np.zeros((len(arrays.positions), 3), np.float32)
    of_vertices[corners] = normals
    if (of_vertices[corners] == normals).all():
        mesh.normals_split_custom_set_from_vertices(of_vertices)
    else:
        mesh.normals_split_custom_set(normals)


def find_split_edges(mesh, values, differ):
    """Returns for each edge whether values of corners differ across it, at one of its ends or both."""
    n_corners = len(mesh.loops)
    edges = get(mesh.loops, "edge_index", np.int32, n_corners).astype(np.int64)
    vertices = get(mesh.loops, "vertex_index", np.int32, n_corners)
    ends = get(mesh.edges, "vertices", np.int32, 2 * len(mesh.edges)).reshape(-1, 2)
    following = np.arange(n_corners).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    # The edge of a corner has this corner and the following one as its ends.
    corner = np.concatenate([np.arange(n_corners), following])
    edge = np.concatenate([edges, edges])
    place = 2 * edge + (vertices[corner] == ends[edge, 1])
    order = np.argsort(place, kind="stable")
    pairs = np.flatnonzero(place[order][1:] == place[order][:-1])
    first, second = order[pairs], order[pairs + 1]
    is_split = np.zeros(len(mesh.edges), bool)
    is_split[edge[first[differ(values[corner[first]], values[corner[second]])]]] = True
    return is_split

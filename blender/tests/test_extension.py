# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests the operators in a Blender without a window, on meshes that it makes itself.
Each test is one promise of the guide."""

import time
from types import SimpleNamespace

import bpy
import neural_mesh as nm
import numpy as np
import pytest
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from blender import convert, preview, simplify
from blender.job import Job
from blender.operators import OBJECT_OT_neural_mesh_simplify
from blender.panel import VIEW3D_PT_neural_mesh
from blender.settings import Carrying, Sizing, copy_settings
from conftest import Layout, add_character, add_sphere, is_closed, make_grid, make_material, move_by_key, n_triangles, positions_of, select


def run(**options):
    assert bpy.ops.object.neural_mesh_simplify(**options) == {"FINISHED"}


def attribute(mesh, name, prop, width):
    data = mesh.attributes[name].data
    return convert.get(data, prop, np.float32, width * len(data)).reshape(-1, width)


def assert_rejected(match, **options):
    with pytest.raises(RuntimeError, match=match):
        bpy.ops.object.neural_mesh_simplify(**options)


@pytest.mark.parametrize("faces", [800, 500])
def test_suzanne_has_the_faces_requested(faces):
    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Subdivision", "SUBSURF")
    run(size_by="FACES", faces=faces, apply_modifiers=False)
    assert abs(len(monkey.data.polygons) - faces) <= 1
    assert [modifier.type for modifier in monkey.modifiers] == ["SUBSURF"]
    assert "UVMap" in monkey.data.uv_layers


def test_modifiers_are_applied_but_armatures():
    body = add_character(n_keys=0, segments=32, rings=16)
    body.modifiers.new("Subdivision", "SUBSURF")
    run(size_by="FACES", faces=1000, apply_modifiers=True)
    assert abs(len(body.data.polygons) - 1000) <= 1
    assert [modifier.type for modifier in body.modifiers] == ["ARMATURE"]
    assert len(body.vertex_groups) == 30


def test_ratio_counts_triangles():
    sphere = add_sphere()
    n = n_triangles(sphere.data)
    run(ratio=0.25)
    assert abs(len(sphere.data.polygons) - n / 4) <= 1
    assert is_closed(sphere.data)


def test_bare_mesh():
    mesh = bpy.data.meshes.new("Grid")
    positions, triangles = make_grid(30)
    mesh.from_pydata(positions.tolist(), [], triangles.tolist())
    item = bpy.data.objects.new("Grid", mesh)
    bpy.context.collection.objects.link(item)
    select(item)
    run(size_by="FACES", faces=400)
    assert abs(len(mesh.polygons) - 400) <= 1
    assert not mesh.uv_layers and not mesh.color_attributes


def test_error_is_met():
    sphere = add_sphere(96, 48)
    sphere.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    original = BVHTree.FromObject(sphere, bpy.context.evaluated_depsgraph_get())
    run(size_by="ERROR_UNITS", error_units=0.02)
    assert len(sphere.data.polygons) < 4000
    assert max(original.find_nearest(vertex.co)[3] for vertex in sphere.data.vertices) * 2 <= 0.02


def test_shape_keys_are_kept():
    body = add_character()
    key = body.data.shape_keys
    names = [block.name for block in key.key_blocks]
    run(ratio=0.2)
    assert body.data.shape_keys == key
    blocks = key.key_blocks
    assert [block.name for block in blocks] == names
    assert blocks["Key2"].mute and blocks["Key3"].relative_key == blocks["Key1"]
    assert blocks["Key4"].vertex_group == "Bone3" and blocks["Key7"].slider_max == 2
    assert key.animation_data.action is not None
    assert key.animation_data.drivers[0].data_path == 'key_blocks["Key6"].value'
    positions = positions_of(body.data)
    for i in range(20):
        moved = convert.get(blocks[f"Key{i}"].data, "co", np.float32, positions.size).reshape(-1, 3)
        # The offsets are smooth, so they can be evaluated at the moved vertices.
        assert np.abs(moved - positions - move_by_key(positions, i)).max() < 0.01


def test_bending_mesh_is_closer_in_shape_keys():
    distances = []
    for bends in (False, True):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        body = add_character()
        original = convert.read_mesh(body, body.data)
        run(ratio=0.1, bends=bends)
        result = convert.read_mesh(body, body.data)
        moved = (original.keys[9], original.triangles), (result.keys[9], result.triangles)
        distances.append(nm.compare(*moved, samples=10_000)["distance_mean"])
    assert distances[1] < distances[0]


def test_vertex_groups_are_kept():
    body = add_character()
    body.vertex_groups["Bone3"].lock_weight = True
    source = convert.read_mesh(body, body.data)
    tree = BVHTree.FromPolygons(source.positions.tolist(), source.triangles.tolist())
    run(ratio=0.2)
    assert [group.name for group in body.vertex_groups] == [f"Bone{i}" for i in range(30)]
    assert body.vertex_groups["Bone3"].lock_weight
    differences = []
    for vertex in body.data.vertices:
        assert abs(sum(element.weight for element in vertex.groups) - 1) < 1e-3
        point, _, triangle, _ = tree.find_nearest(vertex.co)
        corners = source.triangles[triangle]
        shares = poly_3d_calc([Vector(source.positions[corner]) for corner in corners], point)
        naive = {i: float(np.dot(weights[corners], shares)) for i, weights in enumerate(source.groups)}
        differences += [abs(element.weight - naive[element.group]) for element in vertex.groups]
    assert np.mean(differences) < 0.02 and max(differences) < 0.4


def test_armature_bends_the_result_as_the_original():
    body = add_character(n_keys=0)
    copy = body.copy()
    copy.data = body.data.copy()
    bpy.context.collection.objects.link(copy)
    select(body)
    run(ratio=0.2)
    armature = body.modifiers[0].object
    armature.pose.bones["Bone15"].rotation_mode = "XYZ"
    armature.pose.bones["Bone15"].rotation_euler = (0.5, 0, 0)
    armature.pose.bones["Bone20"].location = (0.5, 0, 0)
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    posed = BVHTree.FromObject(copy, graph)
    distances = [posed.find_nearest(vertex.co)[3] for vertex in body.evaluated_get(graph).data.vertices]
    assert np.mean(distances) < 0.01


def test_faces_are_shared_among_objects():
    spheres = [add_sphere(16 + i % 5 * 4, 8 + i % 5 * 2, (3 * i, 0, 0)) for i in range(50)]
    select(*spheres)
    total = sum(n_triangles(sphere.data) for sphere in spheres)
    run(size_by="FACES", faces=total // 4)
    assert abs(sum(n_triangles(sphere.data) for sphere in spheres) - total // 4) <= 1
    assert all(is_closed(sphere.data) for sphere in spheres)


def test_shared_meshes_change_once():
    sphere = add_sphere()
    twin = sphere.copy()
    bpy.context.collection.objects.link(twin)
    select(sphere, twin)
    n = n_triangles(sphere.data)
    run(ratio=0.5)
    assert twin.data == sphere.data and abs(len(sphere.data.polygons) - n / 2) <= 1


def test_texture_seam_stays():
    sphere = add_sphere()
    sphere.data.uv_layers.new(name="Second")
    sphere.data.uv_layers["Second"].active_render = True
    run(ratio=0.2)
    mesh = sphere.data
    assert [layer.name for layer in mesh.uv_layers] == ["UVMap", "Second"]
    assert mesh.uv_layers["Second"].active_render
    widths = np.ptp(attribute(mesh, "UVMap", "vector", 2).reshape(-1, 3, 2)[..., 0], axis=1)
    # A triangle across the seam would be as wide as the texture.
    assert widths.max() < 0.5
    assert is_closed(mesh)


def find_uv_splits(mesh):
    """Returns the edges, by their vertices, at which the texture coordinates of two faces differ."""
    sides, uv = {}, mesh.uv_layers[0].uv
    for polygon in mesh.polygons:
        corners = list(polygon.loop_indices)
        for pair in zip(corners, corners[1:] + corners[:1]):
            ends = sorted((mesh.loops[corner].vertex_index, tuple(np.round(uv[corner].vector, 3))) for corner in pair)
            sides.setdefault(tuple(vertex for vertex, _ in ends), set()).add(tuple(place for _, place in ends))
    return {edge for edge, places in sides.items() if len(places) > 1}


@pytest.mark.parametrize("is_marked", [False, True])
def test_seam_edges_stay_seams(is_marked):
    mesh = add_sphere().data
    mesh.edges[0].use_seam = is_marked
    run(ratio=0.3)
    seams = {tuple(sorted(edge.vertices)) for edge in mesh.edges if edge.use_seam}
    assert seams == (find_uv_splits(mesh) if is_marked else set())
    assert find_uv_splits(mesh)


def test_materials_flat_faces_and_attributes_are_kept():
    sphere = add_sphere()
    mesh = sphere.data
    for name in ("North", "South"):
        mesh.materials.append(bpy.data.materials.new(name))
    for polygon in mesh.polygons:
        polygon.material_index = int(polygon.center.z < 0)
        polygon.use_smooth = polygon.center.z < 0
    height = mesh.attributes.new("height", "FLOAT", "POINT")
    height.data.foreach_set("value", positions_of(mesh)[:, 2].copy())
    part = mesh.attributes.new("part", "INT", "FACE")
    part.data.foreach_set("value", np.array([7 if p.center.x > 0 else 3 for p in mesh.polygons], np.int32))
    run(ratio=0.3)
    assert [material.name for material in mesh.materials] == ["North", "South"]
    for polygon in mesh.polygons:
        assert polygon.material_index == polygon.use_smooth == (polygon.center.z < 0)
    assert np.abs(attribute(mesh, "height", "value", 1)[:, 0] - positions_of(mesh)[:, 2]).max() < 0.03
    assert {item.value for item in mesh.attributes["part"].data} == {3, 7}


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
def test_colors_stay(domain, kind):
    sphere = add_sphere()
    mesh = sphere.data
    mesh.attributes.new("Paint", kind, domain)
    mesh.attributes.active_color_name = "Paint"
    prop = convert.TYPES[kind][0]
    rows = positions_of(mesh)
    if domain == "CORNER":
        rows = rows[convert.get(mesh.loops, "vertex_index", np.int32, len(mesh.loops))]
    colors = np.concatenate([rows / 2 + 0.5, np.ones((len(rows), 1))], axis=1).astype(np.float32)
    mesh.attributes["Paint"].data.foreach_set(prop, colors.ravel())
    run(ratio=0.3)
    paint = mesh.attributes["Paint"]
    assert (paint.domain, paint.data_type, mesh.attributes.active_color_name) == (domain, kind, "Paint")
    rows = positions_of(mesh)
    if domain == "CORNER":
        rows = rows[convert.get(mesh.loops, "vertex_index", np.int32, len(mesh.loops))]
    assert np.abs(attribute(mesh, "Paint", prop, 4)[:, :3] - (rows / 2 + 0.5)).mean() < 0.02


def test_sharp_edges_stay_sharp():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    for edge in cube.data.edges:
        edge.use_edge_sharp = True
    cube.modifiers.new("Subdivision", "SUBSURF").levels = 3
    cube.modifiers[0].subdivision_type = "SIMPLE"
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    for polygon in cube.data.polygons:
        polygon.use_smooth = True
    run(ratio=0.5)
    sharp = [edge for edge in cube.data.edges if edge.use_edge_sharp]
    middles = [(cube.data.vertices[edge.vertices[0]].co + cube.data.vertices[edge.vertices[1]].co) / 2 for edge in sharp]
    assert sharp and all(sorted(np.abs(middle))[1] > 0.99 for middle in middles)
    length = sum((cube.data.vertices[edge.vertices[0]].co - cube.data.vertices[edge.vertices[1]].co).length for edge in sharp)
    assert abs(length - 24) < 0.1


def test_custom_normals_are_set_again():
    sphere = add_sphere()
    mesh = sphere.data
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    mesh.normals_split_custom_set([(0, 0, 1)] * len(mesh.loops))
    run(ratio=0.5)
    assert mesh.has_custom_normals
    normals = convert.get(mesh.corner_normals, "vector", np.float32, 3 * len(mesh.loops)).reshape(-1, 3)
    assert normals[:, 2].min() > 0.99


def test_merging_keeps_vertices_that_shape_keys_separate():
    sphere = add_sphere(16, 8)
    mesh = sphere.data
    source = convert.read_mesh(sphere, mesh)
    source.positions = np.repeat(source.positions[:1], 3, axis=0)
    source.keys = [source.positions, source.positions + [[0, 0, 0], [0, 0, 0], [0, 0, 1]]]
    source.keys[1] = source.keys[1].astype(np.float32)
    source.groups = []
    assert simplify.weld_vertices(source).tolist() == [0, 0, 2]
    source.keys, source.groups = [], [np.array([1, 0.5, 1], np.float32)]
    assert simplify.weld_vertices(source).tolist() == [0, 1, 0]


def test_protected_vertices_keep_more_faces():
    def n_above(protection):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        sphere = add_sphere()
        group = sphere.vertex_groups.new(name="Face")
        group.add([vertex.index for vertex in sphere.data.vertices if vertex.co.z > 0], 1, "REPLACE")
        run(ratio=0.3, protection_group=protection)
        return sum(polygon.center.z > 0 for polygon in sphere.data.polygons)

    assert n_above("Face") > 1.5 * n_above("")


def test_error_colors_have_a_legend():
    sphere = add_sphere()
    run(ratio=0.2, error_colors=True)
    assert sphere["neural_mesh_error_max"] > 0
    colors = attribute(sphere.data, "neural_mesh_error", "color", 4)
    assert (colors == [1, 0, 0, 1]).all(1).any()
    run(ratio=0.5)
    assert "neural_mesh_error_max" not in sphere and "neural_mesh_error" not in sphere.data.attributes


def test_errors_say_why_and_change_nothing():
    assert_rejected("select at least one mesh")
    body = add_character(n_keys=7, segments=24, rings=12)
    before = positions_of(body.data)
    assert_rejected("no vertex group|has a vertex group", importance_group="Nobody")
    assert_rejected("error is 0", size_by="ERROR_UNITS", error_units=0)
    bpy.ops.object.mode_set(mode="EDIT")
    assert_rejected("Object Mode")
    bpy.ops.object.mode_set(mode="OBJECT")
    body.modifiers.new("Multires", "MULTIRES")
    assert_rejected("Multiresolution")
    assert_rejected("Multiresolution", apply_modifiers=False)
    assert (positions_of(body.data) == before).all()
    empty = bpy.data.objects.new("Empty", bpy.data.meshes.new("Empty"))
    bpy.context.collection.objects.link(empty)
    select(empty)
    assert_rejected("no faces")
    select(body)
    with pytest.raises(RuntimeError, match="Ratios"):
        bpy.ops.object.neural_mesh_lods(ratios="2, x")


def test_linked_meshes_are_rejected(tmp_path):
    add_sphere().name = "Ball"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, into):
        into.objects = ["Ball"]
    bpy.context.collection.objects.link(into.objects[0])
    select(into.objects[0])
    assert_rejected("linked from a library")


def paint(item):
    """Gives an object a material whose color is the position and whose roughness is a quarter."""
    material, tree, color = make_material("Paint", roughness=0.25)
    color.node.inputs["Metallic"].default_value = 1
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Object"], color)
    item.data.materials.append(material)


def pixels_at_faces(item, image):
    """Returns the linear color of an image at the middle of each triangle, m x 3."""
    width, height = image.size
    pixels = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(pixels)
    uv = attribute(item.data, "Baked", "vector", 2).reshape(-1, 3, 2).mean(1)
    column, row = (uv * (width, height)).astype(int).clip(0, width - 1).T
    colors = pixels.reshape(height, width, 4)[row, column, :3]
    is_linear = image.colorspace_settings.name != "sRGB"
    return colors if is_linear else np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)


def test_materials_are_baked_to_a_new_one():
    sphere = add_sphere()
    paint(sphere)
    bpy.ops.object.shade_smooth()
    engine = bpy.context.scene.render.engine
    run(ratio=0.1, bake=True, bake_size=256)
    mesh = sphere.data
    assert [material.name for material in mesh.materials] == ["Sphere_Baked"]
    assert mesh.uv_layers.active.name == "Baked" and "UVMap" in mesh.uv_layers
    assert bpy.context.scene.render.engine == engine
    assert bpy.context.selected_objects == [sphere] and list(bpy.data.objects) == [sphere]
    assert sorted(material.name for material in bpy.data.materials) == ["Paint", "Sphere_Baked"]
    corners = positions_of(mesh)[convert.get(mesh.loops, "vertex_index", np.int32, len(mesh.loops))]
    middles = corners.reshape(-1, 3, 3).mean(1).clip(0, 1)
    assert np.abs(pixels_at_faces(sphere, bpy.data.images["Sphere Base Color"]) - middles).mean() < 0.02
    assert np.abs(pixels_at_faces(sphere, bpy.data.images["Sphere Roughness"]) - 0.25).max() < 0.02
    assert np.abs(pixels_at_faces(sphere, bpy.data.images["Sphere Metallic"]) - 1).max() < 0.02
    shader = next(node for node in mesh.materials[0].node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    assert all(shader.inputs[name].links for name in ("Base Color", "Roughness", "Metallic", "Normal"))
    # A baked result can be baked again.
    run(ratio=0.5, bake=True, bake_size=64)
    assert len(mesh.materials) == 1 and mesh.materials[0].name.startswith("Sphere_Baked.")


def test_a_mesh_without_material_is_baked():
    sphere = add_sphere()
    run(ratio=0.1, bake=True, bake_size=64)
    assert np.abs(pixels_at_faces(sphere, bpy.data.images["Sphere Base Color"]) - 0.8).mean() < 0.02


def wait_for_preview():
    """Lets the preview's timer run until its work is done."""
    for _ in range(500):
        assert preview.update() is not None
        if preview.current.job is None and not preview.current.is_outdated:
            return
        time.sleep(0.01)
    raise AssertionError("the preview does not end")


def test_a_preview_follows_the_settings():
    sphere = add_sphere()
    n = len(sphere.data.polygons)
    settings = bpy.context.scene.neural_mesh
    settings.ratio = 0.5
    assert bpy.ops.object.neural_mesh_preview() == {"FINISHED"}
    wait_for_preview()
    copy = bpy.data.objects["Sphere_Preview"]
    assert abs(len(copy.data.polygons) - n_triangles(sphere.data) / 2) <= 1 and sphere.hide_get()
    for ratio in (0.4, 0.3, 0.2):
        settings.ratio = ratio
    wait_for_preview()
    assert abs(len(copy.data.polygons) - n_triangles(sphere.data) / 5) <= 1
    assert preview.current.message == f"{len(copy.data.polygons):,} triangles"
    # The original has not changed, and is as it was when the preview ends.
    assert bpy.ops.object.neural_mesh_preview() == {"FINISHED"}
    assert [item.name for item in bpy.data.objects] == ["Sphere"] and len(sphere.data.polygons) == n
    assert not sphere.hide_get() and sphere.select_get() and preview.update() is None


def test_simplifying_ends_a_preview():
    sphere = add_sphere()
    n = n_triangles(sphere.data)
    bpy.ops.object.neural_mesh_preview()
    wait_for_preview()
    run(ratio=0.25)
    assert [item.name for item in bpy.data.objects] == ["Sphere"] and preview.current is None
    assert abs(len(sphere.data.polygons) - n / 4) <= 1


def test_undo_ends_a_preview():
    sphere = add_sphere()
    n = len(sphere.data.polygons)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.object.neural_mesh_preview()
    wait_for_preview()
    bpy.ops.ed.undo_push(message="while the preview runs")
    bpy.ops.ed.undo()
    assert preview.current is None
    assert [item.name for item in bpy.data.objects] == ["Sphere"]
    assert len(bpy.data.objects["Sphere"].data.polygons) == n and not bpy.data.objects["Sphere"].hide_get()
    bpy.ops.ed.redo()
    assert [item.name for item in bpy.data.objects] == ["Sphere"]


def test_preview_reports_errors():
    with pytest.raises(RuntimeError, match="select at least one mesh"):
        bpy.ops.object.neural_mesh_preview()
    assert preview.current is None


def test_shading_is_kept_by_custom_normals():
    differences = []
    for keep in (True, False):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        sphere = add_sphere()
        bpy.ops.object.shade_smooth()
        run(ratio=0.1, keep_shading=keep)
        mesh = sphere.data
        assert mesh.has_custom_normals == keep
        corners = convert.get(mesh.loops, "vertex_index", np.int32, len(mesh.loops))
        normals = convert.get(mesh.corner_normals, "vector", np.float32, 3 * len(mesh.loops)).reshape(-1, 3)
        outward = positions_of(mesh)[corners]
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        differences.append(1 - (normals * outward).sum(1).mean())
    assert differences[0] < differences[1]
    # Flat faces stay flat with any setting.
    flat = add_sphere()
    run(ratio=0.5)
    assert not flat.data.has_custom_normals and not any(polygon.use_smooth for polygon in flat.data.polygons)


def test_triangles_equal_triangulated_polygons():
    sphere = add_sphere()
    by_polygons = convert.read_mesh(sphere, sphere.data)
    run(ratio=0.999)
    mesh = sphere.data
    fast = convert.read_mesh(sphere, mesh)
    mesh.calc_loop_triangles()
    vertices = convert.get(mesh.loop_triangles, "vertices", np.int32, 3 * len(mesh.polygons)).reshape(-1, 3)
    assert (fast.triangles == vertices).all() and len(fast.triangles) < len(by_polygons.triangles)


def test_undo_restores_original():
    sphere = add_sphere()
    n = len(sphere.data.polygons)
    bpy.ops.ed.undo_push(message="before")
    run(ratio=0.2)
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert len(bpy.data.objects["Sphere"].data.polygons) == n
    bpy.ops.ed.redo()
    assert len(bpy.data.objects["Sphere"].data.polygons) < n


def test_a_result_can_be_saved_and_read(tmp_path):
    body = add_character(n_keys=7)
    run(ratio=0.2)
    n = len(body.data.vertices)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "light.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "light.blend"))
    mesh = bpy.data.objects["Character"].data
    assert len(mesh.vertices) == n
    assert [len(block.data) for block in mesh.shape_keys.key_blocks] == [n] * 8


def test_the_panel_draws_settings_and_legend():
    sphere = add_sphere()
    run(ratio=0.5, error_colors=True)
    layout = Layout()
    VIEW3D_PT_neural_mesh.draw(SimpleNamespace(layout=layout), bpy.context)
    assert ("operator", "object.neural_mesh_simplify") in layout.drawn
    assert any(name == "label" and f"{sphere['neural_mesh_error_max']:.4g}" in text for name, text in layout.drawn)
    operator = SimpleNamespace()
    copy_settings(bpy.context.scene.neural_mesh, operator, Carrying, Sizing)
    assert operator.ratio == 0.5 and operator.keep_components


def test_materials_of_modifiers_are_kept():
    sphere = add_sphere()
    group = bpy.data.node_groups.new("Paint", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    begin, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    paint = group.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = bpy.data.materials.new("Paint")
    group.links.new(begin.outputs[0], paint.inputs["Geometry"])
    group.links.new(paint.outputs[0], end.inputs[0])
    sphere.modifiers.new("Nodes", "NODES").node_group = group
    run(ratio=0.5, apply_modifiers=True)
    index = sphere.data.polygons[0].material_index
    assert sphere.data.materials[index].name == "Paint" and not sphere.modifiers


class Window:
    """Mock of a window's context, which Blender lacks without a window."""

    def __init__(self):
        self.events = []
        self.window_manager = self.workspace = self
        self.window = None

    def __getattr__(self, name):
        return lambda *arguments, **options: self.events.append(name)


def modal_operator(work):
    cls = OBJECT_OT_neural_mesh_simplify
    reports = []
    operator = SimpleNamespace(job=Job(work), timer=None, finish=lambda context: {"FINISHED"})
    operator.report = lambda kind, text: reports.append((kind, text))
    operator.end_progress = lambda context: cls.end_progress(operator, context)
    operator.cancel = lambda context: cls.cancel(operator, context)
    return operator, reports, lambda kind, context: cls.modal(operator, context, SimpleNamespace(type=kind))


def test_escape_stops_the_work_and_leaves_the_mesh():
    def work(tell):
        while True:
            tell(0.5)
            time.sleep(0.01)

    operator, reports, modal = modal_operator(work)
    context = Window()
    assert modal("TIMER", context) == {"RUNNING_MODAL"}
    assert modal("ESC", context) == {"CANCELLED"}
    assert not operator.job.is_running and "progress_end" in context.events
    assert reports == [({"INFO"}, "Stopped: no object has changed")]


def test_a_mesh_without_data_goes_to_the_kernel_alone():
    positions, triangles = make_grid(60)
    task = simplify.Task(None, convert.MeshArrays(positions, triangles), np.eye(4), {"faces": 1000}, None, True, True)
    options = dict(attributes=None, groups=None, importance=None, keep_components=True, for_=None, map=False, progress=lambda done, stage: None)
    light = simplify.simplify_within(task, triangles, options)
    assert "estimated_error" in light.report and len(light.faces) <= 1000
    # Distances of bounds are measured.
    task.bound = 10.0
    assert "estimated_error" not in simplify.simplify_within(task, triangles, options).report


def test_escape_stops_a_simplification():
    source = convert.MeshArrays(*make_grid(700))
    task = simplify.Task(None, source, np.eye(4), {"faces": 1000}, None, True, True)
    operator, _, modal = modal_operator(lambda tell: simplify.simplify_tasks([task], None, tell))
    time.sleep(0.2)
    assert modal("ESC", Window()) == {"CANCELLED"}
    assert task.result is None and operator.job.error is None


def test_thread_error_is_one_line():
    def work(tell):
        raise ValueError("first\nsecond")

    operator, reports, modal = modal_operator(work)
    while operator.job.is_running:
        time.sleep(0.01)
    assert modal("TIMER", Window()) == {"CANCELLED"}
    assert reports == [({"ERROR"}, "first")]

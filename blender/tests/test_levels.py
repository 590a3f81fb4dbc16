# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests levels of detail: their objects, sizes, and files as each engine reads them.
Files are read back by Blender, by the parsers below, and by the Khronos validator where `NEURAL_MESH_VALIDATE` names its script."""

import os
import re
import struct
import subprocess
import zlib

import bpy
import numpy as np
import pytest

from blender import engines, lods
from blender.panel import VIEW3D_PT_neural_mesh
from conftest import Layout, add_character, add_sphere, count_seen, make_material, n_triangles, select

RATIOS = "1, 0.5, 0.1"


def make_levels(**options):
    assert bpy.ops.object.neural_mesh_lods(**{"ratios": RATIOS, **options}) == {"FINISHED"}


def assert_rejected(match, **options):
    with pytest.raises(RuntimeError, match=match):
        make_levels(**options)


def add_actor():
    """Adds a character of two materials, with an armature that moves, and shape keys."""
    body = add_character(n_keys=7, n_groups=4, segments=32, rings=16)
    armature = body.modifiers[0].object
    body.parent = armature
    armature.location = (1, 2, 0)
    # Blender's reader of glTF splits nodes whose shape keys move.
    body.data.shape_keys.animation_data_clear()
    for frame, angle in ((1, 0.0), (20, 0.8)):
        bone = armature.pose.bones["Bone2"]
        bone.rotation_mode = "XYZ"
        bone.rotation_euler = (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)
    for name in ("Skin", "Cloth"):
        body.data.materials.append(make_material(name, roughness=0.5)[0])
    for polygon in body.data.polygons:
        polygon.material_index = int(polygon.center.z < 0)
    select(body)
    bpy.context.view_layer.update()
    return body


def show(original, shown):
    """Shows one level of an object, or the object itself for -1, and selects it."""
    group = lods.find_group(original)
    group["lod"] = shown
    group.update_tag()
    bpy.context.view_layer.update()
    select(original if shown < 0 else lods.find_levels(group)[shown])


def names_of(objects):
    return sorted(item.name for item in objects)


def test_levels_are_siblings_that_share_materials_and_armature():
    body = add_actor()
    armature, before = body.modifiers[0].object, body.matrix_world.copy()
    make_levels()
    group = bpy.data.objects["Character_LODs"]
    assert names_of(bpy.data.objects) == [
        "Armature", "Character", "Character_LOD0", "Character_LOD1", "Character_LOD2", "Character_LODs"
    ]  # fmt: skip
    assert body.parent == armature and not body.children and group.parent == armature
    assert names_of(group.children) == ["Character_LOD0", "Character_LOD1", "Character_LOD2"]
    assert [material.name for material in bpy.data.materials] == ["Cloth", "Skin"]
    n = n_triangles(body.data)
    for level, ratio in zip(lods.find_levels(group), (1, 0.5, 0.1)):
        assert [modifier.object for modifier in level.modifiers] == [armature]
        assert list(level.data.materials) == list(body.data.materials)
        assert abs(n_triangles(level.data) - ratio * n) <= 1
        assert len(level.data.shape_keys.key_blocks) == 8 and len(level.vertex_groups) == 4
        assert np.allclose(level.matrix_world, before, atol=1e-6)
    # The levels follow the original, also while it is hidden.
    body.location.x += 5
    body.update_tag()
    bpy.context.view_layer.update()
    assert np.allclose(bpy.data.objects["Character_LOD0"].matrix_world, body.matrix_world, atol=1e-6)


@pytest.mark.parametrize("shown", [None, -1, 1])
def test_pressed_again_levels_are_replaced(shown):
    """Pressed with the selection that it leaves, with the original, and with a level."""
    body = add_actor()
    make_levels()
    before = names_of(bpy.data.objects), names_of(bpy.data.meshes), names_of(bpy.data.collections)
    if shown is not None:
        show(body, shown)
    make_levels(ratios="1, 0.5, 0.2")
    assert (names_of(bpy.data.objects), names_of(bpy.data.meshes), names_of(bpy.data.collections)) == before
    n = n_triangles(bpy.data.objects["Character"].data)
    assert abs(n_triangles(bpy.data.objects["Character_LOD2"].data) - 0.2 * n) <= 1
    # Fewer levels leave none behind.
    make_levels(ratios="0.5")
    assert names_of(bpy.data.objects["Character_LODs"].children) == ["Character_LOD0"]


def test_one_level_shows_at_a_time():
    body = add_actor()
    make_levels()
    group = bpy.data.objects["Character_LODs"]
    for shown in (-1, 0, 2):
        show(body, shown)
        visible = [item.name for item in (body, *lods.find_levels(group)) if not item.hide_viewport]
        assert visible == ["Character" if shown < 0 else f"Character_LOD{shown}"]


def test_a_taken_name_and_a_lost_original_are_rejected():
    sphere = add_sphere()
    other = bpy.data.objects.new("Sphere_LOD1", None)
    bpy.context.collection.objects.link(other)
    select(sphere)
    assert_rejected("Another object is called Sphere_LOD1")
    bpy.data.objects.remove(other)
    make_levels()
    bpy.data.objects.remove(sphere)
    bpy.data.objects["Sphere_LODs"]["lod"] = 0
    select(bpy.data.objects["Sphere_LOD0"])
    assert_rejected("object that is gone")


@pytest.mark.parametrize("add", ["monkey", "prop", "character"])
def test_sizes_are_reached(add):
    if add == "monkey":
        bpy.ops.mesh.primitive_monkey_add()
    elif add == "prop":
        # Bevelled boxes with texture coordinates, joined to one mesh of many components.
        boxes = []
        for i in range(12):
            bpy.ops.mesh.primitive_cube_add(location=(3 * (i % 4), 3 * (i // 4), 0))
            boxes.append(bpy.context.object)
            boxes[-1].modifiers.new("Bevel", "BEVEL").segments = 3
        select(*boxes)
        bpy.ops.object.convert(target="MESH")
        bpy.ops.object.join()
    else:
        add_character(n_keys=7)
    item = bpy.context.object
    n = n_triangles(item.data)
    ratios = (0.5, 0.3, 0.1, 0.02)
    make_levels(ratios=", ".join(map(str, ratios)))
    for level, ratio in zip(lods.find_levels(lods.find_group(item)), ratios):
        # A collapse removes two triangles.
        assert -2 <= n_triangles(level.data) - round(ratio * n) <= 1, (level.name, n)


def test_sizes_are_those_of_what_is_seen():
    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
    n = count_seen(monkey)
    make_levels(ratios="1, 0.25")
    assert [count_seen(level) for level in lods.find_levels(lods.find_group(monkey))] == [n, n // 4]
    assert [modifier.type for modifier in monkey.modifiers] == ["SUBSURF"]


def test_modifiers_that_stay_are_told(capfd):
    body = add_character(n_keys=7, segments=24, rings=12)
    body.modifiers.new("Subdivision", "SUBSURF")
    n, n_seen = n_triangles(body.data), count_seen(body)
    assert bpy.ops.object.neural_mesh_simplify(ratio=0.5) == {"FINISHED"}
    assert abs(len(body.data.polygons) - n / 2) <= 1
    assert f"the size counts {n:,} triangles, not the {n_seen:,} that its modifiers show" in capfd.readouterr().out


@pytest.mark.parametrize("add, kind", [("curve.primitive_bezier_circle_add", "curve"), ("object.text_add", "text")])
def test_texts_and_curves_are_rejected_with_advice(add, kind):
    module, name = add.split(".")
    getattr(getattr(bpy.ops, module), name)()
    assert_rejected(f"is a {kind}, not a mesh: convert it")


def test_an_object_may_have_its_own_ratio():
    small, large = add_sphere(16, 8), add_sphere(48, 24, (3, 0, 0))
    small.neural_mesh.has_ratio, small.neural_mesh.ratio = True, 0.9
    counts = [n_triangles(item.data) for item in (small, large)]
    select(small, large)
    make_levels(ratios="0.5")
    levels = [lods.find_levels(lods.find_group(item))[0] for item in (small, large)]
    for level, wanted in zip(levels, (0.45 * counts[0], 0.5 * counts[1])):
        assert abs(n_triangles(level.data) - wanted) <= 1
    for item in (small, large):
        show(item, -1)
    select(small, large)
    bpy.ops.object.neural_mesh_simplify(ratio=0.1)
    assert abs(n_triangles(small.data) - 0.9 * counts[0]) <= 1
    assert abs(n_triangles(large.data) - 0.1 * counts[1]) <= 1


def test_levels_share_one_size():
    objects = [add_sphere(16, 8), add_sphere(64, 32, (3, 0, 0))]
    total = sum(n_triangles(item.data) for item in objects)
    select(*objects)
    make_levels(ratios="0.5, 0.25", share_out=True)
    levels = [lods.find_levels(lods.find_group(item)) for item in objects]
    for k, ratio in enumerate((0.5, 0.25)):
        assert abs(sum(n_triangles(own[k].data) for own in levels) - ratio * total) <= 2
    # The sphere with more detail loses a larger share.
    shares = [n_triangles(own[1].data) / n_triangles(item.data) for own, item in zip(levels, objects)]
    assert shares[0] > 1.5 * shares[1]


def test_a_bound_stops_a_size(capfd):
    sphere = add_sphere(96, 48)
    n = n_triangles(sphere.data)
    make_levels(ratios="0.5, 0.01", bound_percent=0.2)
    half, least = lods.find_levels(lods.find_group(sphere))
    assert abs(n_triangles(half.data) - n / 2) <= 1
    diagonal = 2 * 3**0.5
    assert n_triangles(least.data) > 0.02 * n and least[lods.ERROR] <= 0.002 * diagonal
    assert re.search(r"Sphere_LOD1: the bound stops \d+ triangles at \d+", capfd.readouterr().out)


def make_files(folder, engine, item, **options):
    """Makes levels with files and returns the names of these."""
    if item.visible_get():
        select(item)
    make_levels(engine=engine, folder=str(folder), **options)
    return sorted(path.name for path in folder.iterdir())


def read_fbx(path):
    """Returns the children of an FBX file's root, as tuples of name, properties and children."""
    data = path.read_bytes()
    assert data.startswith(b"Kaydara FBX Binary") and struct.unpack_from("<I", data, 23)[0] < 7500

    def read_property(at):
        kind = chr(data[at])
        if kind in "YCIFDL":
            form = {"Y": "h", "C": "b", "I": "i", "F": "f", "D": "d", "L": "q"}[kind]
            return struct.unpack_from(f"<{form}", data, at + 1)[0], at + 1 + struct.calcsize(form)
        if kind in "SR":
            n = struct.unpack_from("<I", data, at + 1)[0]
            return data[at + 5 : at + 5 + n], at + 5 + n
        n, encoding, size = struct.unpack_from("<III", data, at + 1)
        raw = data[at + 13 : at + 13 + size]
        form = {"f": "f", "d": "d", "l": "q", "i": "i", "b": "b"}[kind]
        return np.frombuffer(zlib.decompress(raw) if encoding else raw, f"<{form}", n), at + 13 + size

    def read_node(at):
        end, n_properties, size, n_name = struct.unpack_from("<IIIB", data, at)
        if end == 0:
            return None, at + 13
        name, at = data[at + 13 : at + 13 + n_name].decode(), at + 13 + n_name
        values, children, stop = [], [], at + size
        for _ in range(n_properties):
            value, at = read_property(at)
            values.append(value)
        at = stop
        while at < end:
            child, at = read_node(at)
            if child is not None:
                children.append(child)
        return (name, values, children), end

    nodes, at = [], 27
    while True:
        node, at = read_node(at)
        if node is None:
            return nodes
        nodes.append(node)


def read_fbx_tree(path):
    """Returns of an FBX file: the parent of each model by name, the type of each node attribute, and the names of materials of each model."""
    nodes = {name: children for name, _, children in read_fbx(path)}
    objects = {values[0]: (kind, values[1].split(b"\0")[0].decode(), values[2].decode()) for kind, values, _ in nodes["Objects"]}
    parents, attributes, materials = {}, {}, {}
    for _, (kind, child, parent, *_), _ in nodes["Connections"]:
        what, name, form = objects[child]
        above = objects.get(parent, (None, None, None))
        if what == "Model" and kind == b"OO":
            parents[name] = above[1]
        if what == "NodeAttribute":
            attributes[above[1]] = form
        if what == "Material":
            materials.setdefault(above[1], []).append(child)
    skins = [name for what, name, form in objects.values() if what == "Deformer" and form == "Skin"]
    return parents, attributes, materials, skins


@pytest.mark.parametrize("engine", ["UNITY", "UNREAL"])
def test_fbx_has_levels_under_one_parent(tmp_path, engine):
    body = add_actor()
    assert make_files(tmp_path, engine, body) == ["Character.fbx"]
    parents, attributes, materials, skins = read_fbx_tree(tmp_path / "Character.fbx")
    levels = [f"Character_LOD{k}" for k in range(3)]
    assert [name for name, parent in parents.items() if parent == "Character_LODs"] == levels
    assert attributes["Character_LODs"] == ("LodGroup" if engine == "UNREAL" else "Null")
    # One armature and the same two materials for all, and the original is not there.
    assert "Character" not in parents and [name for name in parents if name.startswith("Armature")] == ["Armature"]
    assert [sorted(materials[name]) for name in levels] == [sorted(materials[levels[0]])] * 3 and len(materials[levels[0]]) == 2
    assert len(skins) == 3


def reimport(path):
    """Reads a file into an empty scene and returns the levels in it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.suffix == ".glb":
        bpy.ops.import_scene.gltf(filepath=str(path))
    else:
        bpy.ops.import_scene.fbx(filepath=str(path))
    return sorted((item for item in bpy.data.objects if "_LOD" in item.name and item.type == "MESH"), key=lambda item: item.name)


@pytest.mark.parametrize("engine, name", [("UNITY", "Character.fbx"), ("UNREAL", "Character.fbx"), ("GODOT", "Character.glb")])
def test_blender_reads_the_files_again(tmp_path, engine, name):
    body = add_actor()
    make_files(tmp_path, engine, body)
    counts = [n_triangles(level.data) for level in lods.find_levels(lods.find_group(body))]
    places = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world @ body.data.vertices[0].co
    levels = reimport(tmp_path / name)
    assert names_of(levels) == ["Character_LOD0", "Character_LOD1", "Character_LOD2"]
    assert [n_triangles(level.data) for level in levels] == counts
    armatures = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    assert len(armatures) == 1 and len(armatures[0].data.bones) >= 4
    for level in levels:
        assert [modifier.object for modifier in level.modifiers if modifier.type == "ARMATURE"] == armatures
        assert len(level.data.shape_keys.key_blocks) >= 7 and {f"Bone{i}" for i in range(4)} <= set(names_of(level.vertex_groups))
        assert names_of(slot for slot in level.data.materials) == ["Cloth", "Skin"]
    seen = [levels[0].matrix_world @ vertex.co for vertex in levels[0].data.vertices]
    assert min((point - places).length for point in seen) < 1e-3
    assert len(bpy.data.materials) == 2


def test_glb_has_levels_of_msft_lod(tmp_path):
    body = add_actor()
    assert make_files(tmp_path, "GLTF", body) == ["Character.glb"]
    document, _ = engines.read_glb(tmp_path / "Character.glb")
    nodes = {node["name"]: (index, node) for index, node in enumerate(document["nodes"])}
    finest = nodes["Character_LOD0"][1]
    coarser = [nodes[f"Character_LOD{k}"][0] for k in (1, 2)]
    assert finest["extensions"] == {"MSFT_lod": {"ids": coarser}} and "MSFT_lod" in document["extensionsUsed"]
    coverages = finest["extras"]["MSFT_screencoverage"]
    assert len(coverages) == 3 and coverages[0] >= coverages[1] >= coverages[2] == 0 and coverages[0] > 0
    placed = [index for owner in document["nodes"] for index in owner.get("children", ())] + document["scenes"][0]["nodes"]
    assert not set(coarser) & set(placed) and nodes["Character_LOD0"][0] in placed
    assert len(document["materials"]) == 2 and len({node["skin"] for _, node in nodes.values() if "skin" in node}) == 1
    sizes = [sum(document["accessors"][it["indices"]]["count"] for it in document["meshes"][nodes[f"Character_LOD{k}"][1]["mesh"]]["primitives"]) // 3 for k in range(3)]
    assert sizes == [n_triangles(bpy.data.objects[f"Character_LOD{k}"].data) for k in range(3)]
    validate(tmp_path / "Character.glb")


def validate(path):
    """Validates a file where the validator is there."""
    script = os.environ.get("NEURAL_MESH_VALIDATE")
    if script:
        subprocess.run([script, str(path)], check=True)


def test_godot_has_a_glb_and_visibility_ranges(tmp_path):
    sphere = add_sphere()
    sphere.name = "Ball.001"
    assert make_files(tmp_path, "GODOT", sphere) == ["Ball_001.glb", "Ball_001_LODs.gd"]
    document, _ = engines.read_glb(tmp_path / "Ball_001.glb")
    names = {node.get("name"): node for node in document["nodes"]}
    children = [document["nodes"][index]["name"] for index in names["Ball.001_LODs"]["children"]]
    assert children == [f"Ball.001_LOD{k}" for k in range(3)]
    script = (tmp_path / "Ball_001_LODs.gd").read_text()
    rows = re.findall(r"\[([\d.e+]+), ([\d.e+]+)\]", script)
    # Each range begins where the one before ends; the script finds the level of a node by one digit.
    begins, ends = [[float(row[k]) for row in rows] for k in (0, 1)]
    assert len(rows) == 3 and '"_LOD") + 4, 1)' in script
    assert begins[0] == 0 and begins[1:] == ends[:-1] and ends[-1] == 0 and begins == sorted(begins)
    # The error of a level is a pixel of 1080 lines at its distance, at 60 degrees.
    error = bpy.data.objects["Ball.001_LOD2"][lods.ERROR]
    assert begins[2] == pytest.approx(error * 540 / np.tan(np.pi / 6), rel=1e-3)
    validate(tmp_path / "Ball_001.glb")


def test_files_of_others_are_not_replaced(tmp_path):
    sphere = add_sphere()
    theirs = tmp_path / "Sphere.glb"
    theirs.write_text("theirs")
    assert_rejected("is there already", engine="GLTF", folder=str(tmp_path))
    assert theirs.read_text() == "theirs" and names_of(bpy.data.objects) == ["Sphere"]
    make_files(tmp_path, "GLTF", sphere, replace_files=True)
    first = theirs.read_bytes()
    # What this extension has written is replaced.
    make_files(tmp_path, "GLTF", sphere, ratios="0.5, 0.1")
    assert theirs.read_bytes() != first
    assert_rejected("There is no folder", engine="GLTF", folder=str(tmp_path / "nowhere"))
    assert_rejected("save it first", engine="GLTF")


def test_files_are_written_beside_the_blend_file(tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    sphere = add_sphere()
    select(sphere)
    make_levels(engine="UNITY")
    assert (tmp_path / "Sphere.fbx").exists()
    # Hidden levels are in the file, and hidden again.
    assert [level.hide_viewport for level in lods.find_levels(lods.find_group(sphere))] == [False, True, True]
    assert names_of(bpy.context.selected_objects) == ["Sphere_LODs"]


def test_the_panel_lists_objects_and_levels():
    sphere = add_sphere()
    n = n_triangles(sphere.data)
    select(sphere)
    make_levels(ratios="0.5")
    show(sphere, -1)
    layout = Layout()
    VIEW3D_PT_neural_mesh.draw(type("Panel", (), {"layout": layout}), bpy.context)
    labels = [text for name, text in layout.drawn if name == "label"]
    assert f"Sphere: {n:,}" in labels and any(f"LOD0: {n // 2:,}" in text for text in labels)
    assert ("prop", "has_ratio") in layout.drawn

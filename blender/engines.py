# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes levels of detail into files as engines take them: names, parents, and where one level takes over from the next.
Unity and Unreal read FBX, Godot and other readers GLB. Each object has a file of its own, with its armature."""

import json
import math
import os
import struct
from pathlib import Path

import bpy

from . import lods, poses, scene
from .job import Refusal

ENDINGS = {"UNITY": (".fbx",), "UNREAL": (".fbx",), "GODOT": (".glb", "_LODs.gd"), "GLTF": (".glb",)}
# Property of the empty: the files that were written for it before, one a line.
FILES = "neural_mesh_files"
# Property of an empty that Blender's FBX exporter writes as the type of its node.
FBX_TYPE = "fbx_type"
# A level is drawn from where its largest error is one pixel of a screen of this height, and of this width to height.
SCREEN_LINES = 1080
SCREEN_ASPECT = 16 / 9
GLB_JSON, GLB_BINARY = 0x4E4F534A, 0x004E4942


def plan_files(original, options):
    """Returns the paths of an object's files; refuses if a file that this extension has not written is in the way."""
    if options.engine == "NONE":
        return []
    if options.folder.startswith("//") and not bpy.data.filepath:
        raise Refusal("Levels are written beside the .blend file: save it first, or choose another folder")
    folder = Path(bpy.path.abspath(options.folder))
    if not folder.is_dir():
        raise Refusal(f"There is no folder {folder}: make it, or choose another one")
    name = bpy.path.clean_name(original.name)
    paths = [folder / f"{name}{ending}" for ending in ENDINGS[options.engine]]
    group = lods.find_group(original)
    own = group.get(FILES, "").splitlines() if group else []
    for path in paths:
        if path.exists() and str(path) not in own and not options.replace_files:
            raise Refusal(f"{path} is there already: choose another folder, or turn Replace Files on")
    return paths


def write_files(context, group, tasks, paths, options):
    """Writes the levels of one object, whose tasks know their errors, for the chosen engine."""
    if options.engine != "UNREAL":
        group.pop(FBX_TYPE, None)
    else:
        group[FBX_TYPE] = "LodGroup"
    if not paths:
        return
    levels = lods.find_levels(group)
    armature = poses.find_armature(levels[0])
    objects = [item for item in (group, *levels, armature) if item is not None]
    with scene.shown(context, objects):
        select_alone(context, objects)
        export = export_fbx if paths[0].suffix == ".fbx" else export_glb
        export(str(paths[0]), options.engine, levels)
    names = [level.name for level in levels]
    if options.engine == "GLTF":
        document, binary = read_glb(paths[0])
        add_levels_extension(document, names, screen_coverages(tasks))
        write_glb(paths[0], document, binary)
    if options.engine == "GODOT":
        script = godot_script(switch_distances(tasks, options.field_of_view))
        paths[1].write_text(script, encoding="utf-8")
    group[FILES] = "\n".join(map(str, paths))


def switch_distances(tasks, field_of_view):
    """Returns from which distance on, in units of the world, each level's largest error is below a pixel; the first is 0."""
    per_unit = SCREEN_LINES / (2 * math.tan(field_of_view / 2))
    distances = [0.0]
    for task in tasks[1:]:
        distances.append(max(task.largest_error * per_unit, distances[-1]))
    return distances


def screen_coverages(tasks):
    """Returns the share of the screen's area down to which each level is drawn; the last is drawn down to 0."""
    size = scene.measure_diagonal(tasks[:1])
    coverages = []
    for task in tasks[1:]:
        height = min(size / max(task.largest_error * SCREEN_LINES, 1e-12), 1.0)
        coverages.append(min([height * height / SCREEN_ASPECT, *coverages[-1:]]))
    return [*coverages, 0.0]


def export_fbx(path, engine, levels):
    """Writes the selected objects by Blender's exporter: a scale of 1 in Unity, an armature's bones alone."""
    call_exporter(
        "fbx",
        filepath=path,
        use_selection=True,
        object_types={"EMPTY", "ARMATURE", "MESH"},
        apply_scale_options="FBX_SCALE_ALL" if engine == "UNITY" else "FBX_SCALE_NONE",
        mesh_smooth_type="FACE",
        add_leaf_bones=False,
        bake_anim_use_all_actions=False,
        bake_anim_use_nla_strips=False,
    )


def export_glb(path, engine, levels):
    """Writes the selected objects by Blender's exporter; modifiers are applied where no shape keys hinder."""
    has_keys = any(level.data.shape_keys for level in levels)
    call_exporter("gltf", filepath=path, export_format="GLB", use_selection=True, export_apply=not has_keys, export_yup=True)


def call_exporter(kind, **options):
    """Calls an exporter of Blender, which is an add-on."""
    if kind not in dir(bpy.ops.export_scene):
        raise Refusal(f"Blender's {kind} exporter is off: turn it on in the preferences, Add-ons")
    try:
        getattr(bpy.ops.export_scene, kind)(**options)
    except RuntimeError as error:
        raise Refusal(f"{options['filepath']}: {error}") from error


def select_alone(context, objects):
    """Selects these objects and no others."""
    layer = context.view_layer
    for item in layer.objects:
        item.select_set(item in objects)
    layer.objects.active = objects[0]


def remove_from_tree(document, removed):
    """Takes nodes of a glTF out of their parents and scenes."""
    for member, owners in (("children", document["nodes"]), ("nodes", document["scenes"])):
        for owner in owners:
            kept = [index for index in owner.get(member, []) if index not in removed]
            owner.pop(member, None)
            # A list must not be empty.
            if kept:
                owner[member] = kept


def add_levels_extension(document, names, coverages):
    """Makes nodes of a glTF levels of the first one (`MSFT_lod`), in whose place the others are drawn."""
    index_of = {node.get("name"): index for index, node in enumerate(document["nodes"])}
    finest, *others = [index_of[name] for name in names]
    remove_from_tree(document, others)
    node = document["nodes"][finest]
    if others:
        node.setdefault("extensions", {})["MSFT_lod"] = {"ids": others}
        node.setdefault("extras", {})["MSFT_screencoverage"] = coverages
        document["extensionsUsed"] = sorted({*document.get("extensionsUsed", []), "MSFT_lod"})


def read_glb(path):
    """Returns the document and the bytes of a GLB file."""
    data, start, chunks = Path(path).read_bytes(), 12, {}
    while start < len(data):
        length, kind = struct.unpack_from("<II", data, start)
        chunks[kind] = data[start + 8 : start + 8 + length]
        start += 8 + length
    return json.loads(chunks[GLB_JSON]), chunks.get(GLB_BINARY, b"")


def write_glb(path, document, binary):
    """Writes a GLB file, whole or not at all."""
    text = json.dumps(document, separators=(",", ":")).encode()
    chunks = b""
    for kind, data, filler in ((GLB_JSON, text, b" "), (GLB_BINARY, binary, b"\0")):
        data += filler * (-len(data) % 4)
        chunks += struct.pack("<II", len(data), kind) + data
    unfinished = Path(f"{path}.part")
    unfinished.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    os.replace(unfinished, path)


def godot_script(distances):
    """Returns the program's script for Godot's import (Import Script), which gives each level its range of distances."""
    ranges = ", ".join(f"[{begin:.4g}, {end:.4g}]" for begin, end in zip(distances, [*distances[1:], 0.0]))
    script = Path(__file__).with_name("levels.gd").read_text(encoding="utf-8")
    return script.replace("RANGES_OF_LEVELS", ranges).replace("N_DIGITS", str(len(str(len(distances) - 1))))

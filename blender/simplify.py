# SPDX-License-Identifier: GPL-3.0-or-later
"""Simplifies arrays of meshes with the package `neural_mesh`, one by one or sharing faces out among several.
Nothing here touches Blender's data, so all of it may run in a thread of its own."""

import warnings
from dataclasses import dataclass, field
from typing import Any

import neural_mesh as nm
import numpy as np

from . import carry, convert, error_colors

# Factor by which importance grows from weight 0 to weight 1 of a vertex group.
MOST_IMPORTANCE = 10.0
MOST_PROTECTION = 1000.0
# Share of the progress that sharing faces out takes, where several meshes are simplified.
SHARING_PROGRESS = 0.3


@dataclass
class Task:
    """One mesh to simplify, and its result."""

    owner: Any
    """Object in Blender, which only the main thread may use."""
    source: convert.MeshArrays
    matrix: np.ndarray
    """Linear part and translation from the mesh to the world, 4 x 4."""
    size: dict
    """Size as `neural_mesh.simplify` takes it, in units of the mesh: `faces` or `error`."""
    importance: np.ndarray | None
    is_welded: bool
    keeps_components: bool
    bends: bool = False
    """Whether the mesh will take poses, those below or, without any, unknown ones."""
    poses: list = field(default_factory=list)
    """Poses, as `poses.Pose`, that the result has to be close to the original in."""
    measures_errors: bool = False
    """Whether vertices are colored by their distance from the original."""
    measures_distance: bool = False
    """Whether the largest distance from the original is measured."""
    bound: float = 0.0
    """Largest distance that a number of faces may cost, in units of the mesh; 0 for none."""
    own_ratio: float | None = None
    """Share of the triangles that this object keeps, whatever the others do."""
    applies_modifiers: bool = False
    note: str = ""
    """What a user should know, in one line."""
    name: str = ""
    materials: list = field(default_factory=list)
    """Materials that the faces number, where modifiers may have brought some."""
    result: convert.MeshArrays | None = None
    largest_error: float = 0.0
    """Largest distance from the original, in units of the world, where that is measured."""
    largest_color_error: float = 0.0
    """Largest distance of a vertex that is colored, in units of the world."""
    outcome: str = "reached"

    @property
    def scale(self):
        """Returns the largest factor by which the object's transform stretches its mesh."""
        return float(np.linalg.norm(self.matrix[:3, :3], 2))


def simplify_tasks(tasks, n_faces=None, progress=None):
    """Simplifies each mesh; with `n_faces` these faces are shared out among all of them first."""
    tell = progress or (lambda done: None)
    begin = 0.0
    if n_faces is not None:
        sharing = [task for task in tasks if not task.size]
        begin = SHARING_PROGRESS if len(sharing) > 1 else 0.0
        share_faces(sharing, n_faces, lambda done, stage: tell(begin * done))
    costs = np.array([len(task.source.triangles) for task in tasks], float)
    ends = begin + (1 - begin) * np.cumsum(costs) / costs.sum()
    for task, start, end in zip(tasks, [begin, *ends], ends):
        simplify_task(task, lambda done, stage: tell(start + (end - start) * done))


def share_faces(tasks, n_faces, progress):
    """Shares a number of faces out among meshes: each gets what it keeps when all are simplified as one mesh."""
    if len(tasks) == 1:
        tasks[0].size = {"faces": n_faces}
        return
    counts = [len(task.source.triangles) for task in tasks]
    starts = np.cumsum([0, *(len(task.source.positions) for task in tasks)])
    positions = [task.source.positions @ task.matrix[:3, :3].T + task.matrix[:3, 3] for task in tasks]
    triangles = [task.source.triangles.astype(np.int64) + start for task, start in zip(tasks, starts)]
    groups = np.repeat(np.arange(len(tasks)), counts)
    light = call_simplify(
        np.concatenate(positions), np.concatenate(triangles), groups=groups, faces=n_faces, keep_components=True, progress=progress
    )
    shares = np.bincount(light.groups, minlength=len(tasks))
    for task, share, count in zip(tasks, shares, counts):
        # A mesh that its transform scales to nothing has no share, and stays as it is.
        task.size = {"faces": int(share) or count}


def simplify_task(task, progress):
    """Sets the result of a task: the simplified mesh with all that the original carries."""
    source = task.source
    if task.size.get("faces", 0) >= len(source.triangles):
        return
    vertex_of = weld_vertices(source) if task.is_welded else np.arange(len(source.positions), dtype=np.int32)
    triangles = vertex_of[source.triangles]
    attributes, names = name_attributes(source)
    poses = {f"morph_{k}": pose.offsets for k, pose in enumerate(task.poses)}
    groups, group_faces = group_triangles(source)
    needs_places = bool(source.keys or source.groups) or any(
        layer.name not in names and layer.name not in carry.BORDER_ATTRIBUTES for layer in source.layers
    )
    options = dict(
        attributes={**attributes, **poses} or None,
        groups=groups,
        importance=task.importance,
        keep_components=task.keeps_components,
        for_="poses" if task.bends else None,
        map=needs_places,
        progress=progress,
    )
    light = simplify_within(task, triangles, options)
    task.outcome = light.outcome if task.outcome == "reached" else task.outcome
    places = None
    if needs_places:
        clean = nm.find_clean_faces(source.positions, triangles, light.report["input"]["faces"], weld=False)
        if clean is None:
            raise nm.NeuralMeshError("some triangles of the mesh are broken: run Mesh > Clean Up > Degenerate Dissolve first")
        places = carry.find_places(source, light, clean)
    fitted = {pose.key: f"morph_{k}" for k, pose in enumerate(task.poses) if pose.key is not None}
    task.result = carry_all(source, light, places, names, group_faces, fitted)
    if task.measures_errors:
        errors = error_colors.measure_errors(source, task.result) * task.scale
        task.largest_color_error = float(errors.max(initial=0))
        task.result.layers.append(error_colors.color_errors(errors, task.largest_color_error))


def simplify_within(task, triangles, options):
    """Returns the result of the task's size, or, if that is farther from the original than its bound, the smallest within the bound."""
    positions, faces = task.source.positions, task.size.get("faces")
    check = task.measures_distance or faces is not None and task.bound > 0
    light = call_simplify(positions, triangles, **task.size, **options, check=check)
    if faces is not None and len(light.faces) > faces and options["keep_components"]:
        # The size comes first: each component needs a few triangles.
        smaller = call_simplify(positions, triangles, **task.size, **{**options, "keep_components": False}, check=check)
        if len(smaller.faces) < len(light.faces):
            light = smaller
            task.note = f"{task.name}: {light.report['output']['components_pruned']:,} components are dropped to reach the size"
    if faces is not None and 0 < task.bound < find_largest_error(task, light):
        light = call_simplify(positions, triangles, error=task.bound, **options, check=check)
        task.outcome = f"the bound stops {faces:,} triangles at {len(light.faces):,}"
    if check:
        task.largest_error = find_largest_error(task, light) * task.scale
    return light


def find_largest_error(task, light):
    """Returns the largest sampled distance of a result from its original, in units of the mesh."""
    diagonal = np.linalg.norm(np.ptp(task.source.positions, axis=0))
    return float(light.report["distance"]["max_percent"] / 100 * diagonal)


def call_simplify(positions, triangles, **options):
    """Calls the simplifier with the extension's settings; the outcome says if the result is larger than requested."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", nm.NeuralMeshWarning)
        # Equal positions are merged here, where shape keys and weights have a say.
        return nm.simplify(positions, triangles, weld=False, **{"check": False, **options})


def weld_vertices(source):
    """Returns for each vertex the first one with equal position, shape keys and weights."""
    random = np.random.default_rng(0)
    columns = [source.positions, *source.keys]
    if source.groups:
        # Weights are compared by random sums: lips that meet at rest follow different bones.
        sums = np.zeros((len(source.positions), 2), np.float32)
        for weights in source.groups:
            for place in range(2):
                sums[:, place] += weights * np.float32(random.random())
        columns.append(np.round(sums, 3))
    # Adding 0 makes one number of 0 and -0.
    rows = np.concatenate(columns, axis=1) + 0
    factors = random.integers(1, 2**63, rows.shape[1], dtype=np.uint64) | np.uint64(1)
    codes = np.zeros(len(rows), np.uint64)
    for column, factor in zip(np.ascontiguousarray(rows.T).view(np.uint32), factors):
        codes += column * factor
    codes ^= codes >> np.uint64(32)
    ordered = np.sort(codes)
    if (ordered[1:] != ordered[:-1]).all():
        return np.arange(len(rows), dtype=np.int32)
    _, first, inverse = np.unique(codes, return_index=True, return_inverse=True)
    vertex_of = first[inverse]
    # Two rows of one code that differ stay apart.
    return np.where((rows[vertex_of] == rows).all(1), vertex_of, np.arange(len(rows))).astype(np.int32)


def name_attributes(source):
    """Returns the attributes for the simplifier at corners, m x 3 x k, and the name it uses for each."""
    attributes, names = {}, {}
    for layer in source.layers:
        is_corner = layer.domain == "CORNER" and layer.is_blended
        if not is_corner and not (layer.domain == "POINT" and layer.is_color):
            continue
        role = "uv" if is_corner and layer.type == "FLOAT2" else "colors" if layer.is_color else ""
        name = role if role and role not in attributes else f"layer {len(names)}"
        names[layer.name] = name
        rows = layer.values if layer.domain == "CORNER" else layer.values[source.triangles]
        attributes[name] = rows.reshape(len(source.triangles), 3, -1)
    if source.normals is not None:
        attributes["normals"] = source.normals
    return attributes, names


def group_triangles(source):
    """Returns a group number for each triangle, by material and flat shading, and one triangle of each group."""
    columns = [layer.values[:, 0].astype(np.int64) for layer in source.layers if layer.name in carry.BORDER_ATTRIBUTES]
    if not columns:
        return None, None
    codes = sum(column << (32 * place) for place, column in enumerate(columns))
    _, first, groups = np.unique(codes, return_index=True, return_inverse=True)
    # A single group has no borders, so none is passed to the simplifier.
    return (groups.reshape(-1), first) if len(first) > 1 else (None, None)


def average_corners(light, name):
    """Returns an attribute at each vertex, n x k: the mean over its corners, which differ along seams."""
    corners, values = light.faces.ravel(), np.asarray(light.corners(name)).reshape(3 * len(light.faces), -1)
    counts = np.maximum(np.bincount(corners, minlength=len(light.vertices)), 1)
    sums = [np.bincount(corners, column, len(light.vertices)) / counts for column in values.T]
    return np.stack(sums, axis=1).astype(np.float32)


def carry_all(source, light, places, names, group_faces, fitted):
    """Returns the result with the layers, shape keys, vertex groups and normals of the original.

    `fitted` names the attributes of the simplifier that are offsets of shape keys, by the key's number.
    """
    positions = np.asarray(light.vertices, np.float32)
    vertex_corners = carry.find_vertex_corners(light)
    layers = []
    for layer in source.layers:
        if layer.name in names:
            values = light.corners(names[layer.name]).reshape(3 * len(light.faces), -1)
            values = values[vertex_corners] if layer.domain == "POINT" else values
        elif layer.name in carry.BORDER_ATTRIBUTES:
            # All triangles have the values of the first one where there is a single group.
            faces = np.zeros(len(light.faces), int) if light.groups is None else group_faces[light.groups]
            values = layer.values[faces]
        else:
            values = carry.carry_values(source, places, layer)
        layers.append(convert.Layer(layer.name, layer.domain, layer.type, values))
    return convert.MeshArrays(
        positions=positions,
        triangles=np.asarray(light.faces),
        layers=layers,
        keys=carry.carry_keys(source, places, positions, {key: average_corners(light, name) for key, name in fitted.items()}),
        groups=carry.carry_groups(source, places),
        normals=None if source.normals is None else light.corners("normals"),
        has_custom_normals=source.has_custom_normals,
        has_seams=source.has_seams,
    )

"""Twenty props of hard surfaces, as an artist of games makes them: modelled, bevelled, unwrapped, with face-weighted normals."""

import math

import bmesh
import bpy

# Edges whose faces differ by more are bevelled, or sharp in a prop without bevels.
SHARP = math.radians(30)


def add_object(fill):
    """Adds an object whose mesh `fill` makes."""
    mesh = bpy.data.meshes.new("Prop")
    form = bmesh.new()
    fill(form)
    bmesh.ops.recalc_face_normals(form, faces=form.faces)
    form.to_mesh(mesh)
    form.free()
    item = bpy.data.objects.new("Prop", mesh)
    bpy.context.collection.objects.link(item)
    return item


def box(size, place=(0, 0, 0)):
    def fill(form):
        made = bmesh.ops.create_cube(form, size=1)["verts"]
        bmesh.ops.scale(form, vec=size, verts=made)
        bmesh.ops.translate(form, vec=place, verts=made)

    return add_object(fill)


def extrude(outline, height, place=(0, 0, 0)):
    """Adds a prism over a polygon."""

    def fill(form):
        face = form.faces.new([form.verts.new((x, y, 0)) for x, y in outline])
        top = bmesh.ops.extrude_face_region(form, geom=[face])["geom"]
        bmesh.ops.translate(form, vec=(0, 0, height), verts=[part for part in top if isinstance(part, bmesh.types.BMVert)])
        bmesh.ops.translate(form, vec=place, verts=form.verts)

    return add_object(fill)


def circle(radius, n, phase=0.0):
    return [(radius * math.cos(2 * math.pi * (i + phase) / n), radius * math.sin(2 * math.pi * (i + phase) / n)) for i in range(n)]


def cylinder(radius, height, n=48, place=(0, 0, 0)):
    return extrude(circle(radius, n), height, place)


def lathe(profile, n=48, is_closed=False):
    """Adds a profile of radius and height turned around z; ends at radius 0 are poles."""

    def fill(form):
        rings = []
        for radius, height in profile:
            points = circle(radius, n) if radius else [(0.0, 0.0)]
            rings.append([form.verts.new((x, y, height)) for x, y in points])
        pairs = list(zip(rings, rings[1:])) + ([(rings[-1], rings[0])] if is_closed else [])
        for low, high in pairs:
            for i in range(n):
                corners = [low[i % len(low)], low[(i + 1) % len(low)], high[(i + 1) % len(high)], high[i % len(high)]]
                form.faces.new(list(dict.fromkeys(corners)))

    return add_object(fill)


def sweep(radius, path, n=24):
    """Adds a capped tube along points of the plane x, y."""

    def fill(form):
        rings = []
        for i, (x, y) in enumerate(path):
            (ax, ay), (bx, by) = path[max(i - 1, 0)], path[min(i + 1, len(path) - 1)]
            length = math.hypot(bx - ax, by - ay)
            across = (-(by - ay) / length, (bx - ax) / length)
            rings.append([form.verts.new((x + u * across[0], y + u * across[1], v)) for u, v in circle(radius, n)])
        for low, high in zip(rings, rings[1:]):
            for i in range(n):
                form.faces.new([low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]])
        form.faces.new(rings[0][::-1])
        form.faces.new(rings[-1])

    return add_object(fill)


def change(item, kind, **settings):
    """Applies a modifier."""
    modifier = item.modifiers.new(kind, kind)
    for name, value in settings.items():
        setattr(modifier, name, value)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    return item


def cut(item, tool, operation="DIFFERENCE"):
    change(item, "BOOLEAN", object=tool, operation=operation, solver="EXACT")
    bpy.data.objects.remove(tool)
    return item


def drill(item, places, radius, n=32, height=4.0):
    for x, y in places:
        cut(item, cylinder(radius, height, n, (x, y, -height / 2)))
    return item


def join(items):
    bpy.ops.object.select_all(action="DESELECT")
    for item in items:
        item.select_set(True)
    bpy.context.view_layer.objects.active = items[0]
    bpy.ops.object.join()
    return items[0]


def unwrap(item, method):
    bpy.ops.object.select_all(action="DESELECT")
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    if not item.data.uv_layers:
        item.data.uv_layers.new(name="UVMap")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    if method == "cube":
        bpy.ops.uv.cube_project(cube_size=4.0)
    else:
        bpy.ops.uv.smart_project(angle_limit=math.radians(66), island_margin=0.005)
    bpy.ops.object.mode_set(mode="OBJECT")


def finish(item, width=0.03, segments=3, method="smart"):
    """Bevels edges by `width`, or makes them sharp at 0, unwraps, weights the normals by faces, and makes triangles."""
    form = bmesh.new()
    form.from_mesh(item.data)
    bmesh.ops.remove_doubles(form, verts=form.verts, dist=1e-5)
    bmesh.ops.dissolve_limit(form, angle_limit=math.radians(0.1), verts=form.verts, edges=form.edges)
    form.to_mesh(item.data)
    form.free()
    if width:
        change(item, "BEVEL", width=width, segments=segments, limit_method="ANGLE", angle_limit=SHARP, use_clamp_overlap=True)
    item.data.shade_smooth()
    if not width:
        item.data.set_sharp_from_angle(angle=SHARP)
    unwrap(item, method)
    change(item, "WEIGHTED_NORMAL", weight=50, keep_sharp=True)
    return change(item, "TRIANGULATE", keep_custom_normals=True)


def make_gear(n_teeth, inner, outer, height):
    outline = []
    for i in range(n_teeth):
        for share, radius in ((0.0, inner), (0.22, inner), (0.36, outer), (0.62, outer), (0.76, inner)):
            angle = 2 * math.pi * (i + share) / n_teeth
            outline.append((radius * math.cos(angle), radius * math.sin(angle)))
    return extrude(outline, height)


def make_crate():
    crate = box((2, 2, 2))
    for axis in range(3):
        for side in (-1, 1):
            size, place = [1.5, 1.5, 1.5], [0, 0, 0]
            size[axis], place[axis] = 0.2, side
            crate = cut(crate, box(size, place))
    return crate


def make_stairs():
    outline = [(0, 0)]
    for i in range(8):
        outline += [(0.3 * i, 0.2 * (i + 1)), (0.3 * (i + 1), 0.2 * (i + 1))]
    return extrude(outline + [(2.4, 0)], 1.2)


def make_elbow():
    arc = [(1 + math.cos(math.pi - t), math.sin(t)) for t in (math.pi / 2 * i / 16 for i in range(17))]
    pipe = sweep(0.3, [(0, -0.8)] + arc + [(1.8, 1.0)], 32)
    inner = sweep(0.22, [(0, -1.0)] + arc + [(2.0, 1.0)], 32)
    return cut(pipe, inner)


def make_wheel():
    rim = lathe([(0.85, -0.15), (1.0, -0.2), (1.0, 0.2), (0.85, 0.15)], 64, is_closed=True)
    hub = cylinder(0.22, 0.4, 32, (0, 0, -0.2))
    spokes = []
    for i in range(5):
        spoke = box((0.75, 0.14, 0.12), (0.52, 0, 0))
        spoke.rotation_euler = (0, 0, 2 * math.pi * i / 5)
        spokes.append(spoke)
    for part in [hub, *spokes]:
        bpy.context.view_layer.update()
        cut(rim, part, "UNION")
    return drill(rim, [(0, 0)], 0.1, 24)


def make_shelf():
    posts = [box((0.1, 0.1, 2.4), (x, y, 0)) for x in (-0.95, 0.95) for y in (-0.35, 0.35)]
    boards = [box((1.9, 0.75, 0.06), (0, 0, z)) for z in (-1.0, -0.35, 0.3, 0.95)]
    return join(posts + boards)


def make_vent():
    panel = box((2.4, 1.6, 0.2))
    for i in range(7):
        panel = cut(panel, box((0.16, 1.1, 0.14), (-0.9 + 0.3 * i, 0, 0.1)))
    return drill(panel, [(x, y) for x in (-1.1, 1.1) for y in (-0.7, 0.7)], 0.05, 16)


def make_flange():
    ring = cut(cylinder(1, 0.25, 64), cylinder(0.45, 1, 48, (0, 0, -0.5)))
    return drill(ring, circle(0.72, 6), 0.1, 24)


def make_hinge():
    leaf = box((1.4, 2.0, 0.1), (0.75, 0, 0))
    leaf = drill(leaf, [(0.9, y) for y in (-0.7, 0.0, 0.7)], 0.12, 24)
    barrel = cylinder(0.14, 2.0, 32, (0, 0, -1.0))
    barrel.rotation_euler = (math.pi / 2, 0, 0)
    bpy.context.view_layer.update()
    return cut(leaf, barrel, "UNION")


def make_tee():
    pipe = cylinder(0.4, 2.4, 48, (0, 0, -1.2))
    branch = cylinder(0.3, 1.4, 48)
    branch.rotation_euler = (0, math.pi / 2, 0)
    bpy.context.view_layer.update()
    return cut(pipe, branch, "UNION")


BEAM = [
    *((-0.5, -0.6), (0.5, -0.6), (0.5, -0.5), (0.06, -0.5), (0.06, 0.5), (0.5, 0.5)),
    *((0.5, 0.6), (-0.5, 0.6), (-0.5, 0.5), (-0.06, 0.5), (-0.06, -0.5), (-0.5, -0.5)),
]
ANGLE = [(0, 0), (1.6, 0), (1.6, 0.2), (0.2, 0.2), (0.2, 1.6), (0, 1.6)]
BARREL = [
    *((0, 0), (0.7, 0), (0.72, 0.1), (0.78, 0.5), (0.84, 0.55), (0.84, 0.63), (0.79, 0.68), (0.8, 1.2)),
    *((0.85, 1.25), (0.85, 1.33), (0.78, 1.38), (0.72, 1.9), (0.7, 2.0), (0.62, 2.0), (0.62, 1.92), (0, 1.92)),
]
SHAFT = [
    *((0, 0), (0.3, 0), (0.3, 0.6), (0.42, 0.6), (0.42, 1.1), (0.25, 1.1)),
    *((0.25, 1.2), (0.42, 1.2), (0.42, 1.6), (0.2, 1.6), (0.2, 2.4), (0, 2.4)),
]
SQUARE = [(x, y) for x in (-0.8, 0.8) for y in (-0.8, 0.8)]
GRID = [(0.5 * i - 0.75, 0.5 * j - 0.5) for i in range(4) for j in range(3)]

PROPS = {
    "box": lambda: finish(box((2, 1.4, 1)), 0.1, 4),
    "crate": lambda: finish(make_crate(), 0.04, 3),
    "plate": lambda: finish(drill(box((2, 2, 0.2)), SQUARE, 0.15), 0.03, 3),
    "grating": lambda: finish(drill(box((2.4, 1.8, 0.15)), GRID, 0.16, 24), 0.02, 2, "cube"),
    "bracket": lambda: finish(cut(extrude(ANGLE, 1), box((0.5, 0.8, 0.4), (1.0, 0, 0.5))), 0.04, 3, "cube"),
    "cylinder": lambda: finish(cylinder(0.7, 1.6, 64), 0.06, 4),
    "shaft": lambda: finish(lathe(SHAFT, 64), 0),
    "barrel": lambda: finish(lathe(BARREL), 0.015, 2),
    "elbow": lambda: finish(make_elbow(), 0.02, 2),
    "tee": lambda: finish(make_tee(), 0.03, 2),
    "flange": lambda: finish(make_flange(), 0.02, 2),
    "gear": lambda: finish(drill(make_gear(18, 0.8, 1.0, 0.3), [(0, 0)], 0.3), 0.02, 2, "cube"),
    "bolt": lambda: finish(cut(extrude(circle(0.5, 6), 0.35), cylinder(0.25, 1.6, 40, (0, 0, -1.5)), "UNION"), 0.03, 3),
    "nut": lambda: finish(drill(extrude(circle(0.5, 6), 0.4), [(0, 0)], 0.26, 40), 0.03, 3),
    "beam": lambda: finish(extrude(BEAM, 4), 0.03, 3, "cube"),
    "stairs": lambda: finish(make_stairs(), 0.02, 2, "cube"),
    "wheel": lambda: finish(make_wheel(), 0.02, 2),
    "shelf": lambda: finish(make_shelf(), 0.015, 2),
    "vent": lambda: finish(make_vent(), 0.02, 2),
    "hinge": lambda: finish(make_hinge(), 0.02, 2),
}

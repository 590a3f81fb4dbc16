"""Writes and reads mesh files with the standard library alone.

A mesh is a pair (points, faces): points n x 3 in the unit of the mesh, faces m x 3 of indices. A reader gives what the file
holds in its own numbers: single precision comes back as the doubles equal to it, text as the nearest doubles.
"""

import json
import struct
from array import array


class Unreadable(Exception):
    """Raised for a file that violates its format."""


def write(path, points, faces, double=False):
    """Writes a mesh as the ending of the path says; `double` is for PLY, text holds every digit."""
    writers = {".ply": write_ply, ".obj": write_obj, ".off": write_off, ".stl": write_stl, ".glb": write_glb}
    writers[path.suffix](path, points, faces, double)


def write_ply(path, points, faces, double):
    kind, code = ("double", "3d") if double else ("float", "3f")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property {kind} {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = b"".join(struct.pack("<" + code, *point) for point in points)
    path.write_bytes(head.encode() + rows + b"".join(struct.pack("<B3i", 3, *face) for face in faces))


def write_obj(path, points, faces, _double):
    lines = ["v %r %r %r\n" % tuple(point) for point in points] + ["f %d %d %d\n" % (a + 1, b + 1, c + 1) for a, b, c in faces]
    path.write_text("".join(lines))


def write_off(path, points, faces, _double):
    lines = ["%r %r %r\n" % tuple(point) for point in points] + ["3 %d %d %d\n" % tuple(face) for face in faces]
    path.write_text(f"OFF\n{len(points)} {len(faces)} 0\n" + "".join(lines))


def write_stl(path, points, faces, _double):
    rows = [struct.pack("<12fH", 0, 0, 0, *points[a], *points[b], *points[c], 0) for a, b, c in faces]
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + b"".join(rows))


def write_glb(path, points, faces, _double):
    indices, places = array("I", [v for face in faces for v in face]), array("f", [x for point in points for x in point])
    bounds = [[function(places[axis::3]) for axis in range(3)] for function in (min, max)]
    views = [{"buffer": 0, "byteLength": 4 * len(indices)}]
    views.append({"buffer": 0, "byteOffset": 4 * len(indices), "byteLength": 4 * len(places)})
    accessors = [{"bufferView": 0, "componentType": 5125, "count": len(indices), "type": "SCALAR"}]
    accessors.append({"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC3"})
    accessors[1].update(min=bounds[0], max=bounds[1])
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    scene["meshes"] = [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}]
    data = indices.tobytes() + places.tobytes()
    scene.update(bufferViews=views, accessors=accessors, buffers=[{"byteLength": len(data)}])
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON")
    path.write_bytes(head + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def read(path):
    """Reads the mesh of a file; polygons become fans of triangles."""
    readers = {".ply": read_ply, ".obj": read_obj, ".off": read_off, ".stl": read_stl, ".glb": read_glb}
    try:
        points, faces = readers[path.suffix](path.read_bytes())
    except (ValueError, KeyError, IndexError, struct.error, UnicodeDecodeError) as error:
        raise Unreadable(f"{type(error).__name__}: {error}") from error
    if any(not 0 <= v < len(points) for face in faces for v in face):
        raise Unreadable("a face names a vertex that does not exist")
    return points, faces


def fan(corners):
    return [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]


SCALARS = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
SCALARS.update(int8="b", uint8="B", int16="h", uint16="H", int32="i", uint32="I", float32="f", float64="d")


def read_ply(data):
    head, found, body = data.partition(b"end_header\n")
    if not found:
        raise Unreadable("no end of the header")
    elements, order = [], None
    for words in (line.split() for line in head.decode().splitlines()):
        if words[0] == "format":
            order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}[words[1]]
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
    rows = text_rows(body.split(), elements) if order is None else packed_rows(body, elements, order)
    kinds = {words[-1]: words[0] for name, _, some in elements for words in some if name == "vertex"}
    points, faces = [], []
    for name, row in rows:
        if name == "vertex":
            points.append(tuple(single(row[axis]) if kinds[axis].startswith("float") else row[axis] for axis in "xyz"))
        elif name == "face":
            faces += fan(row.get("vertex_indices") or row["vertex_index"])
    return points, faces


def text_rows(words, elements):
    """Yields each row of a text PLY by name; floats represent the integers exactly."""
    words = iter(words)
    for name, count, some in elements:
        for _ in range(count):
            row = {}
            for kind, *_, key in some:
                row[key] = [int(next(words)) for _ in range(int(next(words)))] if kind == "list" else float(next(words))
            yield name, row


def packed_rows(body, elements, order):
    """Yields each row of a binary PLY by name."""
    at = 0
    for name, count, some in elements:
        for _ in range(count):
            row = {}
            for kind, *more, key in some:
                code = SCALARS[kind if kind != "list" else more[1]]
                n_values = 1
                if kind == "list":
                    (n_values,) = struct.unpack_from(order + SCALARS[more[0]], body, at)
                    at += struct.calcsize("<" + SCALARS[more[0]])
                values = struct.unpack_from(f"{order}{n_values}{code}", body, at)
                at += struct.calcsize(f"<{n_values}{code}")
                row[key] = values if kind == "list" else values[0]
            yield name, row


def single(x):
    """Rounds a number to single precision."""
    return struct.unpack("<f", struct.pack("<f", x))[0] if abs(x) < 3.4028235677973366e38 else x


def read_obj(data):
    points, faces = [], []
    for words in (line.split() for line in data.decode().splitlines()):
        if words and words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words and words[0] == "f":
            corners = [int(word.split("/")[0]) for word in words[1:]]
            faces += fan([v - 1 if v > 0 else len(points) + v for v in corners])
    return points, faces


def read_off(data):
    words = iter(data.split())
    if next(words) != b"OFF":
        raise Unreadable("no OFF")
    n_points, n_faces, _ = (int(next(words)) for _ in range(3))
    points = [tuple(float(next(words)) for _ in range(3)) for _ in range(n_points)]
    return points, [face for _ in range(n_faces) for face in fan([int(next(words)) for _ in range(int(next(words)))])]


def read_stl(data):
    """Reads the corners of all facets, each as a separate point."""
    if data[:6] == b"solid " and b"facet" in data[:400]:
        words = data.split()
        points = [tuple(single(float(x)) for x in words[i + 1 : i + 4]) for i, word in enumerate(words) if word == b"vertex"]
    else:
        (count,) = struct.unpack_from("<I", data, 80)
        rows = [struct.unpack_from("<9f", data, 96 + 50 * face) for face in range(count)]
        points = [row[i : i + 3] for row in rows for i in (0, 3, 6)]
    return points, [(i, i + 1, i + 2) for i in range(0, len(points), 3)]


def read_glb(data):
    """Reads all triangles of the scene; nodes of this script and the program have at most a translation."""
    _, _, _, length = struct.unpack_from("<4sIII", data)
    scene, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    points, faces = [], []

    def values(accessor, code, width):
        accessor = scene["accessors"][accessor]
        view = scene["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step = view.get("byteStride", struct.calcsize("<" + code) * width)
        return [struct.unpack_from(f"<{width}{code}", binary, start + step * i) for i in range(accessor["count"])]

    for node in scene["nodes"]:
        if set(node) & {"matrix", "rotation", "scale"}:
            raise Unreadable("a node that does more than translate")
        shift = node.get("translation", (0.0, 0.0, 0.0))
        for primitive in scene["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            if primitive.get("mode", 4) != 4:
                continue
            first = len(points)
            places = values(primitive["attributes"]["POSITION"], "f", 3)
            points += [tuple(x + s for x, s in zip(place, shift)) for place in places]
            code = {5121: "B", 5123: "H", 5125: "I"}[scene["accessors"][primitive["indices"]]["componentType"]]
            corners = [first + v for (v,) in values(primitive["indices"], code, 1)]
            faces += [tuple(corners[i : i + 3]) for i in range(0, len(corners), 3)]
    return points, faces

"""Reads glTF 2.0 scenes, as JSON or GLB, and places their triangles as a viewer does; shares no code with the program.

Reads sparse accessors, normalised integers, quantised meshes, data URIs, lists, strips and fans, default morph weights, skins at
their bind pose, GPU instances and, by DracoPy, geometry compressed by Draco. Raises `Unsupported` for what meshopt compressed.
"""

import base64
import json
import struct
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

import numpy as np

DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
COMPRESSED = {"EXT_meshopt_compression", "KHR_meshopt_compression"}
DRACO = "KHR_draco_mesh_compression"
# A triangle counts as degenerate below this share of its longest edge squared: rounding of single precision gives less.
NO_AREA = 1e-12


class Unsupported(Exception):
    """What keeps a scene from being read."""


@dataclass
class Primitive:
    """Triangles with one material, in the coordinates of their mesh."""

    mesh: int
    material: int | None
    points: np.ndarray  # n_vertices x 3
    faces: np.ndarray  # n_faces x 3, without degenerate ones
    attributes: dict  # name -> n_vertices x width


@dataclass
class Triangles:
    """Placed triangles without degenerate ones; arrays per corner are n x 3 x width."""

    corners: np.ndarray
    normals: np.ndarray  # unit length: the stored ones, else those of the face
    uvs: np.ndarray  # of the texture of the base colour
    colours: np.ndarray  # linear RGB, factors of materials included
    materials: np.ndarray  # n, -1 where there is none


def read_document(path):
    """Returns the JSON of a glTF and the binary chunk of a GLB, which is empty for others."""
    data = Path(path).read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    chunks, at = {}, 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<I4s", data, at)
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    return json.loads(chunks[b"JSON"]), chunks.get(b"BIN\0", b"")


def find_referred_files(document):
    """Returns the relative paths of the buffers and of the images that a glTF keeps in files of their own."""
    def paths(key):
        uris = [entry.get("uri", "data:") for entry in document.get(key, [])]
        return [unquote(uri) for uri in uris if not uri.startswith("data:")]
    return paths("buffers"), paths("images")


def has_area(corners):
    """Returns which of the triangles (n x 3 x 3) are finite and have an area."""
    edges = corners - np.roll(corners, 1, axis=1)
    longest = np.max(np.sum(edges**2, axis=2), axis=1, initial=0)
    with np.errstate(invalid="ignore"):
        return np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) > NO_AREA * longest


def normalize(vectors):
    """Scales vectors (... x 3) to unit length; leaves those of length zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)


class Asset:
    """A glTF file with its buffers."""

    def __init__(self, path):
        self.folder = Path(path).parent
        self.document, binary = read_document(path)
        compressed = COMPRESSED.intersection(self.document.get("extensionsRequired", []))
        if compressed:
            raise Unsupported(f"compressed by {', '.join(sorted(compressed))}")
        if not str(self.document.get("asset", {}).get("version")).startswith("2"):
            raise Unsupported("not glTF 2.0")
        self.buffers = [self.read_uri(entry["uri"]) if "uri" in entry else binary for entry in self.entries("buffers")]
        self.primitives = [p for mesh in range(len(self.entries("meshes"))) for p in self.read_primitives(mesh)]

    def entries(self, key):
        return self.document.get(key, [])

    def read_uri(self, uri):
        """Returns the bytes that a URI holds or names."""
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        path = self.folder / unquote(uri)
        if not path.is_file():
            raise Unsupported(f"{unquote(uri)} is missing")
        return path.read_bytes()

    def read_view(self, index, dtype, width, count, offset):
        """Returns count x width numbers of a buffer view."""
        view = self.document["bufferViews"][index]
        dtype = np.dtype(dtype)
        stride = view.get("byteStride", dtype.itemsize * width)
        start = view.get("byteOffset", 0) + offset
        shape, strides = (count, width), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, self.buffers[view["buffer"]], start, strides) if count else np.zeros(shape, dtype)

    def read_accessor(self, index):
        """Returns an accessor as count x width doubles."""
        accessor = self.document["accessors"][index]
        kind, width, count = DTYPES[accessor["componentType"]], WIDTHS[accessor["type"]], accessor["count"]
        values = np.zeros((count, width), kind)
        if "bufferView" in accessor:
            values = self.read_view(accessor["bufferView"], kind, width, count, accessor.get("byteOffset", 0)).copy()
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where, what = sparse["indices"], sparse["values"]
            n_rows, of_rows = sparse["count"], DTYPES[where["componentType"]]
            rows = self.read_view(where["bufferView"], of_rows, 1, n_rows, where.get("byteOffset", 0))
            values[rows[:, 0]] = self.read_view(what["bufferView"], kind, width, n_rows, what.get("byteOffset", 0))
        if accessor.get("normalized"):
            return np.maximum(values / np.iinfo(kind).max, -1)
        return values.astype(float)

    def read_primitives(self, mesh):
        """Reads the triangles of a mesh at its default morph weights."""
        entry = self.document["meshes"][mesh]
        for primitive in entry["primitives"]:
            if primitive.get("mode", 4) < 4 or "POSITION" not in primitive["attributes"]:
                continue
            attributes, order = self.read_vertices(primitive)
            for weight, target in zip(entry.get("weights", []), primitive.get("targets", []), strict=False):
                for name in {"POSITION", "NORMAL"}.intersection(target if weight else {}):
                    attributes[name] = attributes[name] + weight * self.read_accessor(target[name])
            points = attributes.pop("POSITION")
            faces = to_triangles(order, primitive.get("mode", 4))
            faces = faces[np.all(faces < len(points), axis=1)]
            yield Primitive(mesh, primitive.get("material"), points, faces[has_area(points[faces])], attributes)

    def read_vertices(self, primitive):
        """Returns the attributes of a primitive and the order in which its triangles use them."""
        packed = primitive.get("extensions", {}).get(DRACO)
        if packed:
            import DracoPy

            view = self.document["bufferViews"][packed["bufferView"]]
            mesh = DracoPy.decode(self.read_view(packed["bufferView"], "u1", 1, view["byteLength"], 0).tobytes())
            tables = {name: mesh.get_attribute_by_unique_id(index)["data"] for name, index in packed["attributes"].items()}
            return {name: np.asarray(table, float) for name, table in tables.items()}, mesh.faces.astype(int).ravel()
        attributes = {name: self.read_accessor(index) for name, index in primitive["attributes"].items()}
        if "indices" in primitive:
            return attributes, self.read_accessor(primitive["indices"])[:, 0].astype(int)
        return attributes, np.arange(len(attributes["POSITION"]))

    def read_mesh_names(self):
        return [mesh.get("name", f"mesh {index}") for index, mesh in enumerate(self.entries("meshes"))]

    def count_faces(self):
        """Returns how many triangles each mesh has, counted once however many nodes place it."""
        counts = np.zeros(len(self.entries("meshes")), int)
        for primitive in self.primitives:
            counts[primitive.mesh] += len(primitive.faces)
        return counts

    def count_placed_faces(self):
        """Returns how many triangles the default scene shows, counted at each place."""
        counts = self.count_faces()
        return int(sum(counts[mesh] for mesh, _ in self.find_placements()))

    def count_vertices(self):
        """Returns how many different positions the triangles of each mesh use, summed over meshes."""
        used = {}
        for primitive in self.primitives:
            used.setdefault(primitive.mesh, []).append(primitive.points[primitive.faces].reshape(-1, 3))
        return sum(len(np.unique(np.concatenate(points), axis=0)) for points in used.values())

    def find_placements(self):
        """Returns (mesh, 4 x 4 matrix) for each place at which the default scene shows a mesh."""
        nodes, world, order = self.entries("nodes"), {}, []
        scenes = self.entries("scenes")
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [node for node in range(len(nodes)) if node not in children]
        shown = set(scenes[self.document.get("scene", 0)].get("nodes", []) if scenes else roots)
        # Joints may lie outside of the scene, so all nodes get their matrix.
        open_nodes = [(root, np.eye(4), False) for root in reversed(roots)]
        while open_nodes:
            index, outer, is_shown = open_nodes.pop()
            is_shown |= index in shown
            world[index] = outer @ to_matrix(nodes[index])
            order += [index] if is_shown and "mesh" in nodes[index] else []
            open_nodes += [(child, world[index], is_shown) for child in reversed(nodes[index].get("children", []))]
        places = [(node, matrix) for node in order for matrix in self.find_matrices(nodes[node], world[node], world)]
        return [(nodes[node]["mesh"], matrix) for node, matrix in places]

    def find_matrices(self, node, own, world):
        """Returns the matrices of one node: of its skin at the bind pose, of its instances, or its own."""
        if "skin" in node:
            skin = self.document["skins"][node["skin"]]
            joint = world[skin["joints"][0]]
            if "inverseBindMatrices" not in skin:
                return [joint]
            return [joint @ self.read_accessor(skin["inverseBindMatrices"])[0].reshape(4, 4).T]
        instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes")
        if not instances:
            return [own]
        table = {key.lower(): self.read_accessor(index) for key, index in instances.items() if not key.startswith("_")}
        count = max(map(len, table.values()), default=0)
        return [own @ to_matrix({key: rows[i] for key, rows in table.items()}) for i in range(count)]

    def place_scene(self):
        """Returns the triangles of the default scene, all of them where its nodes place them."""
        places = [(p, matrix) for mesh, matrix in self.find_placements() for p in self.primitives if p.mesh == mesh]
        if not any(len(primitive.faces) for primitive, _ in places):
            raise Unsupported("no triangles")
        tables = [self.place_primitive(primitive, matrix) for primitive, matrix in places]
        whole = [np.concatenate([getattr(table, name) for table in tables]) for name in Triangles.__annotations__]
        keep = has_area(whole[0])
        return Triangles(*(values[keep] for values in whole))

    def place_primitive(self, primitive, matrix):
        faces, attributes = primitive.faces, primitive.attributes
        corners = (primitive.points @ matrix[:3, :3].T + matrix[:3, 3])[faces]
        # The matrix of normals is the cofactor matrix, turned where the placement mirrors.
        a, b, c = matrix[:3, :3].T
        side = np.sign(np.linalg.det(matrix[:3, :3])) or 1.0
        of_faces = side * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = normalize(of_faces)[:, None].repeat(3, axis=1)
        if "NORMAL" in attributes:
            cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
            stored = normalize(side * attributes["NORMAL"][faces] @ cofactors.T)
            is_given = np.linalg.norm(stored, axis=2, keepdims=True) > 0
            normals = np.where(is_given, stored, normals)
        colours = attributes.get("COLOR_0", np.ones((len(primitive.points), 3)))[:, :3][faces]
        factor, uv_set, transform = self.read_base_colour(primitive.material)
        uvs = attributes.get(f"TEXCOORD_{uv_set}", np.zeros((len(primitive.points), 2)))[faces]
        uvs = np.concatenate([uvs, np.ones_like(uvs[..., :1])], axis=2) @ transform.T
        index = -1 if primitive.material is None else primitive.material
        return Triangles(corners, normals, uvs[..., :2], colours * factor, np.full(len(faces), index))

    def read_base_colour(self, material):
        """Returns the factor, the set of texture coordinates and their 3 x 3 transform of a material's base colour."""
        look = {} if material is None else self.document["materials"][material].get("pbrMetallicRoughness", {})
        texture = look.get("baseColorTexture", {})
        turned = texture.get("extensions", {}).get("KHR_texture_transform", {})
        (x, y), (u, v) = turned.get("offset", (0, 0)), turned.get("scale", (1, 1))
        cos, sin = np.cos(turned.get("rotation", 0)), np.sin(turned.get("rotation", 0))
        transform = np.array([[u * cos, v * sin, x], [-u * sin, v * cos, y], [0, 0, 1]])
        uv_set = turned.get("texCoord", texture.get("texCoord", 0))
        return np.array(look.get("baseColorFactor", (1, 1, 1)))[:3], uv_set, transform

    def read_base_image(self, material):
        """Returns the bytes of the image of a material's base colour; None where it has none or the file is missing."""
        look = {} if material < 0 else self.document["materials"][material].get("pbrMetallicRoughness", {})
        source = "baseColorTexture" in look and self.document["textures"][look["baseColorTexture"]["index"]].get("source")
        if source is False or source is None:
            return None
        image = self.document["images"][source]
        if "uri" in image:
            is_there = image["uri"].startswith("data:") or (self.folder / unquote(image["uri"])).is_file()
            return self.read_uri(image["uri"]) if is_there else None
        view = self.document["bufferViews"][image["bufferView"]]
        return self.read_view(image["bufferView"], "u1", 1, view["byteLength"], 0).tobytes()


def to_triangles(order, mode):
    """Returns the triangles of a list (4), strip (5) or fan (6) of vertices, n x 3."""
    if mode == 4:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(order) - 2, 0))
    if mode == 5:
        return order[np.stack([i, i + 1 + i % 2, i + 2 - i % 2], axis=1)]
    return order[np.stack([i + 1, i + 2, np.zeros_like(i)], axis=1)]


def to_matrix(node):
    """Returns the matrix of a node, given as such or as translation, rotation and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = to_unit_quaternion(node.get("rotation", (0, 0, 0, 1)))
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)))
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def to_unit_quaternion(rotation):
    length = np.linalg.norm(rotation)
    return np.array(rotation) / length if length > 0 else (0, 0, 0, 1)

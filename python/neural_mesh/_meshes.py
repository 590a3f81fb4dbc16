"""Converts meshes to arrays and back: pairs of arrays, files, trimesh, Open3D, pyvista, meshio, PyMeshLab, and results of this package."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import NeuralMeshError, OptionError
from ._result import Light, split

# Name and role of known attributes in the compiled module; files are then written with the columns that other programs read.
_ROLES = {
    **dict.fromkeys(("uv", "uvs", "texcoord", "texture_coordinates"), ("uv", "uv")),
    **dict.fromkeys(("normal", "normals"), ("normal", "normal")),
    **dict.fromkeys(("tangent", "tangents"), ("tangent", "tangent")),
    **dict.fromkeys(("color", "colors", "colour", "colours"), ("colour", "colour")),
}
# Names of a file's attributes in results, by role.
_ROLE_NAMES = {"uv": "uv", "normal": "normals", "tangent": "tangents", "colour": "colors"}
# Names under which pyvista's readers store materials and groups as cell data.
_GROUP_NAMES = ("materialids", "material_ids", "materialid", "material", "groupids", "group_ids", "groupid", "groups", "group")


@dataclass(frozen=True)
class AttributeName:
    """Name, type and shape of an input attribute, for restoring it in the result."""

    name: str
    dtype: np.dtype[Any]
    is_flat: bool
    """Whether it has one number per vertex, shape n."""


@dataclass
class MeshInput:
    """A mesh as the compiled module takes it, with what restores the input's types in the result."""

    path: str | None = None
    file: tuple[bytes, str] | None = None
    """Bytes and name of a file."""
    arrays: Any = None
    """Vertices, faces, wedges, channels and groups; `None` for a file."""
    names: dict[str, AttributeName] = field(default_factory=dict)
    face_values: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Values of faces that do not constrain the simplification, by name."""
    ignores_groups: bool = False
    """Whether borders of materials and groups in a file may move."""
    group_values: NDArray[Any] | None = None
    """Input value of each group number."""
    like: Any = None
    """Input array whose type results take."""
    back: Callable[[Light[Any]], Any] = lambda light: (light.vertices, light.faces)
    scene: Callable[[bytes | None, Light[Any]], Any] | None = None
    """Makes a scene of the result's file, for an input scene."""

    @property
    def is_scene(self) -> bool:
        return self.scene is not None

    def describe_dirt(self, cleaned: Mapping[str, int]) -> list[str]:
        """Describes the faces that were removed as invalid, one line per kind."""
        kinds = {"non_finite_faces": "with coordinates that are not finite", "out_of_range_faces": "with indices out of range"}
        dirt = [f"{cleaned[name]} faces {kind} were left out" for name, kind in kinds.items() if cleaned.get(name)]
        if self.arrays is not None and cleaned.get("out_of_range_faces"):
            vertices, faces = self.arrays[:2]
            # The likely cause: an array in the numbering of OBJ files.
            is_from_one = faces.min() == 1 and faces.max() == len(vertices)
            dirt[-1] += ": indices begin at 1: subtract 1" if is_from_one else ": indices are rows of vertices, from 0 on"
        return dirt

    def raise_if_dirty(self, cleaned: Mapping[str, int]) -> None:
        """Raises `NeuralMeshError` if faces are invalid."""
        dirt = self.describe_dirt(cleaned)
        if dirt:
            raise NeuralMeshError("; ".join(dirt).replace("were left out", "are in the mesh"))

    def convert_like(self, array: NDArray[Any]) -> Any:
        return convert_like(self.like, array)

    def name_channels(self, channels: Sequence[tuple[str, str, NDArray[np.float32]]]) -> dict[str, NDArray[Any]]:
        """Returns the result's attributes under the input's names and types."""
        attributes: dict[str, NDArray[Any]] = {}
        for name, role, values in channels:
            input_name, array = self._name_channel(name, role, values)
            # Only the first of several channels of a role gets the role's name.
            attributes[name if input_name in attributes else input_name] = array
        return attributes

    def _name_channel(self, name: str, role: str, values: NDArray[np.float32]) -> tuple[str, NDArray[Any]]:
        known = self.names.get(name)
        if known is None:
            return _ROLE_NAMES.get(role, name), values
        result: NDArray[Any] = values
        if known.dtype == np.uint8 and _role(known.name, known.dtype)[1] == "colour":
            result = np.clip(np.rint(values * 255), 0, 255)
        elif np.issubdtype(known.dtype, np.integer):
            result = np.rint(values)
        result = result.astype(known.dtype, copy=False)
        return known.name, result.reshape(-1) if known.is_flat else result

    def restore_groups(self, groups: NDArray[np.int32] | None) -> NDArray[Any] | None:
        if groups is None or self.group_values is None:
            return groups
        values: NDArray[Any] = self.group_values[groups]
        return values

    def spread_to_welded(self, values: NDArray[np.int32]) -> NDArray[np.int32]:
        """Gives vertices with value -1 the value of a vertex at an equal position, if it has one."""
        if self.arrays is None or not (values < 0).any():
            return values
        # Adding 0 makes 0 and -0 equal.
        _, position = np.unique(self.arrays[0] + 0, axis=0, return_inverse=True)
        largest = np.full(int(position.max()) + 1, -1, np.int32)
        np.maximum.at(largest, position.reshape(-1), values)
        return largest[position.reshape(-1)]


def read_input(mesh: Any, attributes: Mapping[str, ArrayLike] | None, groups: Any, on_dirty: str = "ignore") -> MeshInput:
    """Reads a mesh of any supported type; with `on_dirty` "raise", rejects invalid faces in arrays."""
    file = _read_file(mesh)
    if file is not None:
        if attributes is not None or not (groups is None or isinstance(groups, str) and groups == "auto"):
            raise OptionError("attributes and groups: a file has its own: leave both out; groups=None discards the groups of the file")
        file.ignores_groups = groups is None
        return file
    fields = _read_mesh(mesh)
    if attributes is not None:
        if not isinstance(attributes, Mapping) or not all(isinstance(name, str) for name in attributes):
            raise OptionError("attributes: give arrays by name, such as {'uv': array}, with text for names")
        fields["attributes"] = {**fields.get("attributes", {}), **attributes}
    _choose_groups(fields, groups)
    packed = _pack_input(**fields)
    if on_dirty == "raise":
        _check(packed)
    return packed


def _read_file(mesh: Any) -> MeshInput | None:
    """Reads a path, bytes, an open file, or a trimesh scene as a file; returns `None` for anything else."""
    if isinstance(mesh, (str, os.PathLike)):
        return MeshInput(path=_file_name(mesh))
    if isinstance(mesh, (bytes, bytearray, memoryview)):
        return MeshInput(file=(bytes(mesh), ""))
    # A mesh of meshio has a method of that name, too.
    if callable(getattr(mesh, "read", None)) and _kind(mesh) != "meshio":
        content, name = mesh.read(), getattr(mesh, "name", "")
        data = content.encode() if isinstance(content, str) else bytes(content)
        return MeshInput(file=(data, name if isinstance(name, str) else ""))
    if _kind(mesh) == "trimesh" and hasattr(mesh, "geometry") and not hasattr(mesh, "faces"):
        return MeshInput(file=(bytes(mesh.export(file_type="glb")), "scene.glb"), scene=_trimesh_scene)
    return None


def _kind(mesh: Any) -> str:
    """Returns the name of the package that defines the type of a mesh."""
    return type(mesh).__module__.partition(".")[0]


def _trimesh_scene(data: bytes | None, light: Light[Any]) -> Any:
    """Loads the resulting scene from its bytes, or from the written file without them."""
    import trimesh

    if data is None:
        return trimesh.load_scene(light.paths[0])
    return trimesh.load_scene(io.BytesIO(data), file_type="glb")


def _choose_groups(fields: dict[str, Any], groups: Any) -> None:
    """Chooses the groups whose borders stay; other face values do not constrain the simplification."""
    face_values = dict(fields.get("face_values") or {})
    auto, name = fields.get("groups"), fields.pop("groups_name", None)
    chosen: Any = groups
    if isinstance(groups, str) and groups == "auto":
        chosen = auto
        face_values.pop(name, None)
    elif isinstance(groups, str):
        if groups not in face_values:
            known = ", ".join(face_values) or "none"
            raise OptionError(f"groups={groups!r}: there are no such face values: choose from {known}")
        chosen = face_values.pop(groups)
    fields["groups"], fields["face_values"] = chosen, face_values


def _check(packed: MeshInput) -> None:
    """Raises `NeuralMeshError` for arrays with invalid faces."""
    vertices, faces = packed.arrays[:2]
    out_of_range = (faces >= len(vertices)).any(1)
    non_finite = ~np.isfinite(vertices).all(1)
    broken = non_finite[faces[~out_of_range]].any(1)
    packed.raise_if_dirty({"non_finite_faces": int(broken.sum()), "out_of_range_faces": int(out_of_range.sum())})


def _file_name(path: str | os.PathLike[str]) -> str:
    name = os.fspath(path)
    if name.startswith("-"):
        # The program would read a leading `-` as an option.
        return os.path.join(".", name)
    return name


def points_of(cloud: Any) -> tuple[str | None, NDArray[Any] | None]:
    """Returns a point cloud as the path of its file, or as an array of its points (n x 3)."""
    if isinstance(cloud, (str, os.PathLike)):
        return _file_name(cloud), None
    if not (hasattr(cloud, "__array__") or hasattr(cloud, "__dlpack__") or isinstance(cloud, (list, tuple))):
        cloud = next((getattr(cloud, name) for name in ("points", "vertices") if hasattr(cloud, name)), cloud)
    return None, _positions(cloud)


def convert_like(like: Any, array: NDArray[Any]) -> Any:
    """Converts an array to the type of another: a torch tensor on its device, a jax array, or numpy."""
    kind = type(like).__module__.partition(".")[0]
    if kind == "torch":
        import torch

        return torch.from_numpy(np.ascontiguousarray(array)).to(like.device)
    if kind in ("jax", "jaxlib"):
        import jax.numpy as jnp

        return jnp.asarray(array)
    return array


def _read_mesh(mesh: Any) -> dict[str, Any]:
    """Reads the arrays of a mesh as arguments of `_pack_input`, with the function that restores its type."""
    kind = _kind(mesh)
    if isinstance(mesh, Light):
        return _read_light(mesh)
    if kind == "meshio":
        return _read_meshio(mesh)
    if kind == "trimesh":
        return _read_trimesh(mesh)
    if kind == "open3d":
        return _read_open3d(mesh)
    if kind == "pyvista":
        return _read_pyvista(mesh)
    if kind == "pymeshlab":
        return _read_pymeshlab(mesh)
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return {"vertices": mesh[0], "faces": mesh[1]}
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return {"vertices": mesh.vertices, "faces": mesh.faces}
    raise NeuralMeshError(
        f"{type(mesh).__name__}: not a mesh: give a file, (vertices, faces), or a mesh of trimesh, Open3D, pyvista, meshio or PyMeshLab"
    )


def _read_light(light: Light[Any]) -> dict[str, Any]:
    attributes = {name: light.corners(name) for name in light.attributes}
    flat = {name for name, values in light.attributes.items() if values.ndim == 1}
    attributes.update({name: attributes[name][..., None] for name in flat})
    fields = {"vertices": light.vertices, "faces": light.faces, "attributes": attributes, "groups": light.groups}
    return {**fields, "face_values": light.face_attributes, "flat": flat}


def _pack_input(
    vertices: Any,
    faces: Any,
    attributes: Mapping[str, ArrayLike] | None = None,
    groups: ArrayLike | None = None,
    face_values: Mapping[str, Any] | None = None,
    flat: Collection[str] = (),
    back: Callable[[Light[Any]], Any] | None = None,
) -> MeshInput:
    positions, corners = _positions(vertices), _faces(faces)
    wedges, channels, names = _channels(len(positions), corners, attributes or {}, flat)
    numbers, group_values = _groups(groups, len(corners))
    packed = MeshInput(arrays=(positions, corners, wedges, channels, numbers), names=names, group_values=group_values, like=vertices)
    packed.face_values = {name: array_of(values) for name, values in (face_values or {}).items()}
    if back is not None:
        packed.back = back
    return packed


def array_of(values: Any) -> NDArray[Any]:
    """Converts an array-like to numpy: by `__array__` or DLPack; tensors on a GPU are copied."""
    if isinstance(values, np.ma.MaskedArray):
        raise NeuralMeshError("a masked array: give a plain one, such as array.filled(0), or the rows that are not masked")
    if hasattr(values, "detach") and hasattr(values, "cpu"):
        values = values.detach().cpu()
    if not hasattr(values, "__array__") and hasattr(values, "__dlpack__"):
        return np.from_dlpack(values)
    return np.asarray(values)


def pack(values: Any, dtype: Any) -> NDArray[Any]:
    """Returns an array of a type whose numbers lie next to each other, in place, and aligned."""
    return np.require(values, dtype, ["C", "A"])


def _positions(values: Any) -> NDArray[Any]:
    positions = array_of(values)
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise NeuralMeshError(f"vertices: an array of shape {positions.shape}: give n x 3")
    if not (np.issubdtype(positions.dtype, np.number) and not np.issubdtype(positions.dtype, np.complexfloating)):
        raise NeuralMeshError(f"vertices: an array of {positions.dtype}: give numbers")
    is_single = positions.dtype in (np.dtype(np.float32), np.dtype(np.float16))
    return pack(positions, np.float32 if is_single else np.float64)


def _faces(values: Any) -> NDArray[np.uint32]:
    faces = array_of(values)
    if faces.size == 0:
        return np.zeros((0, 3), np.uint32)
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise NeuralMeshError(f"faces: an array of shape {faces.shape}: give triangles, n x 3")
    if not np.issubdtype(faces.dtype, np.integer):
        raise NeuralMeshError(f"faces: an array of {faces.dtype} such as {faces.flat[0]}: give whole numbers, rows of vertices from 0 on")
    if faces.dtype == np.int32:
        # Negative indices become out of range, and are cleaned as such.
        return pack(faces, np.int32).view(np.uint32)
    if faces.dtype.itemsize > 4:
        faces = np.where((faces < 0) | (faces > 0xFFFFFFFF), 0xFFFFFFFF, faces)
    return pack(faces, np.uint32)


def _channels(
    n_vertices: int, faces: NDArray[np.uint32], attributes: Mapping[str, ArrayLike], flat: Collection[str]
) -> tuple[Any, Any, dict[str, AttributeName]]:
    """Returns wedges, channels and attribute names: one wedge per vertex, or per corner if any attribute has corner values.

    Attributes in `flat` have one number per row and come back without the last axis."""
    arrays = {name: array_of(values) for name, values in attributes.items()}
    if not arrays:
        return None, [], {}
    n_faces = len(faces)
    at_corners = {name for name, values in arrays.items() if values.ndim == 3 and values.shape[:2] == (n_faces, 3)}
    channels, names = [], {}
    for name, values in arrays.items():
        if name not in at_corners and (values.ndim not in (1, 2) or len(values) != n_vertices):
            shape = f"{n_vertices} (vertices) or {n_faces} x 3 (corners)"
            raise NeuralMeshError(f"{name}: an array of shape {values.shape}: give rows for {shape}")
        native_name, role = _role(name, values.dtype)
        scale = 255 if role == "colour" and values.dtype == np.uint8 else 1
        rows = (values.reshape(3 * n_faces, -1) if name in at_corners else values.reshape(n_vertices, -1)).astype(np.float32) / scale
        if at_corners and name not in at_corners:
            rows = rows[np.minimum(faces, max(n_vertices - 1, 0)).reshape(-1)]
        if native_name in names:
            raise NeuralMeshError(f"{name}: there is another attribute of that kind: give it another name")
        channels.append((native_name, role, pack(rows, np.float32)))
        names[native_name] = AttributeName(name, values.dtype, values.ndim == 1 or name in flat)
    wedges = np.arange(3 * n_faces, dtype=np.uint32).reshape(-1, 3) if at_corners else faces
    return wedges, channels, names


def _role(name: str, dtype: np.dtype[Any]) -> tuple[str, str]:
    """Returns an attribute's name and role in the compiled module."""
    default = "label" if np.issubdtype(dtype, np.integer) or dtype == np.bool_ else "other"
    return _ROLES.get(name.lower(), (name, "morph" if re.fullmatch(r"morph_\d+", name) else default))


def _groups(groups: ArrayLike | None, n_faces: int) -> tuple[NDArray[np.uint32] | None, NDArray[Any] | None]:
    if groups is None:
        return None, None
    values = array_of(groups)
    if values.shape != (n_faces,):
        raise NeuralMeshError(f"groups: an array of shape {values.shape}: give one number for each of {n_faces} faces")
    group_values, numbers = np.unique(values, return_inverse=True)
    return np.ascontiguousarray(numbers.reshape(-1), dtype=np.uint32), group_values


def _read_trimesh(mesh: Any) -> dict[str, Any]:
    if not hasattr(mesh, "faces"):
        raise NeuralMeshError(f"trimesh.{type(mesh).__name__}: not a mesh: give a Trimesh or a Scene")
    attributes = {name: values for name, values in mesh.vertex_attributes.items() if np.asarray(values).ndim in (1, 2)}
    face_values = {name: np.asarray(values) for name, values in mesh.face_attributes.items()}
    visual = mesh.visual
    if getattr(visual, "uv", None) is not None:
        attributes["uv"] = visual.uv
    elif visual.kind == "vertex":
        attributes["colors"] = np.asarray(visual.vertex_colors)
    elif visual.kind == "face":
        face_values["face_colors"] = np.asarray(visual.face_colors)

    def back(light: Light[Any]) -> Any:
        import trimesh

        vertices, faces, values = light.split()
        lighter = trimesh.Trimesh(vertices, faces, process=False, metadata=dict(mesh.metadata))
        values_of_faces = dict(light.face_attributes)
        colours = values_of_faces.pop("face_colors", None)
        if "uv" in values:
            lighter.visual = trimesh.visual.TextureVisuals(uv=values.pop("uv"), material=getattr(visual, "material", None))
        elif "colors" in values:
            lighter.visual.vertex_colors = values.pop("colors")
        elif colours is not None:
            lighter.visual.face_colors = colours
        lighter.vertex_attributes.update(values)
        lighter.face_attributes.update(values_of_faces)
        return lighter

    return {"vertices": np.asarray(mesh.vertices), "faces": np.asarray(mesh.faces), "attributes": attributes, "face_values": face_values, "back": back}


def _read_open3d(mesh: Any) -> dict[str, Any]:
    import open3d as o3d

    if isinstance(mesh, o3d.t.geometry.TriangleMesh):
        return _read_open3d_tensors(mesh)
    if not isinstance(mesh, o3d.geometry.TriangleMesh):
        raise NeuralMeshError(f"open3d {type(mesh).__name__}: not a triangle mesh")
    faces = np.asarray(mesh.triangles)
    attributes: dict[str, Any] = {}
    if mesh.has_vertex_colors():
        attributes["colors"] = np.asarray(mesh.vertex_colors)
    if mesh.has_vertex_normals():
        attributes["normals"] = np.asarray(mesh.vertex_normals)
    if mesh.has_triangle_uvs():
        attributes["uv"] = np.asarray(mesh.triangle_uvs).reshape(-1, 3, 2)
    groups = np.asarray(mesh.triangle_material_ids) if mesh.has_triangle_material_ids() else None

    def back(light: Light[Any]) -> Any:
        # Open3D stores colours and normals per vertex, texture coordinates per corner.
        of_vertices = {name: values for name, values in light.attributes.items() if name != "uv"}
        vertices, corners = np.asarray(light.vertices), np.asarray(light.faces)
        if of_vertices:
            vertices, corners, of_vertices = split(vertices, corners, light.wedges, of_vertices)
        lighter = o3d.geometry.TriangleMesh(
            o3d.utility.Vector3dVector(np.asarray(vertices, np.float64)), o3d.utility.Vector3iVector(corners)
        )
        if "colors" in of_vertices:
            lighter.vertex_colors = o3d.utility.Vector3dVector(of_vertices["colors"].astype(np.float64))
        if "normals" in of_vertices:
            lighter.vertex_normals = o3d.utility.Vector3dVector(of_vertices["normals"].astype(np.float64))
        if "uv" in light.attributes:
            lighter.triangle_uvs = o3d.utility.Vector2dVector(light.corners("uv").reshape(-1, 2).astype(np.float64))
            lighter.textures = mesh.textures
        if light.groups is not None:
            lighter.triangle_material_ids = o3d.utility.IntVector(light.groups)
        return lighter

    return {"vertices": np.asarray(mesh.vertices), "faces": faces, "attributes": attributes, "groups": groups, "back": back}


def _read_open3d_tensors(mesh: Any) -> dict[str, Any]:
    """Reads an Open3D tensor mesh, whose attributes have names."""
    import open3d as o3d

    cpu = mesh.cpu()
    of_vertices = {name: cpu.vertex[name].numpy() for name in cpu.vertex if name != "positions"}
    face_values = {name: cpu.triangle[name].numpy() for name in cpu.triangle if name not in ("indices", "texture_uvs", "normals")}
    attributes: dict[str, Any] = {name: values for name, values in of_vertices.items() if values.ndim in (1, 2)}
    if "texture_uvs" in cpu.triangle:
        attributes["uv"] = cpu.triangle["texture_uvs"].numpy()
    ids = face_values.get("material_ids")

    def tensor(values: Any) -> Any:
        return o3d.core.Tensor.from_numpy(np.ascontiguousarray(values))

    def back(light: Light[Any]) -> Any:
        at_vertices = {name: values for name, values in light.attributes.items() if name != "uv"}
        vertices, corners = np.asarray(light.vertices), np.asarray(light.faces)
        if at_vertices:
            vertices, corners, at_vertices = split(vertices, corners, light.wedges, at_vertices)
        kind = cpu.vertex["positions"].numpy().dtype
        lighter = o3d.t.geometry.TriangleMesh(tensor(vertices.astype(kind)), tensor(corners.astype(np.int32)))
        for name, values in at_vertices.items():
            lighter.vertex[name] = tensor(values)
        if "uv" in light.attributes:
            lighter.triangle["texture_uvs"] = tensor(light.corners("uv"))
        for name, values in light.face_attributes.items():
            lighter.triangle[name] = tensor(values)
        if light.groups is not None and ids is not None:
            lighter.triangle["material_ids"] = tensor(light.groups.astype(ids.dtype).reshape(-1, *ids.shape[1:]))
        if mesh.has_valid_material():
            lighter.material = mesh.material
        return lighter.to(mesh.device)

    fields = {"vertices": cpu.vertex["positions"].numpy(), "faces": cpu.triangle["indices"].numpy(), "attributes": attributes}
    groups = None if ids is None else ids.reshape(-1)
    return {**fields, "face_values": face_values, "groups": groups, "groups_name": "material_ids", "back": back}


def _read_meshio(mesh: Any) -> dict[str, Any]:
    """Reads triangles and quadrilaterals; a mesh with other cells of two or three dimensions is refused."""
    import meshio

    flat = {"triangle", "quad"}
    others = {block.type for block in mesh.cells} - flat - {"vertex", "line"}
    if others or not any(block.type in flat for block in mesh.cells):
        kinds = ", ".join(sorted(others)) or "no faces"
        raise NeuralMeshError(f"meshio.Mesh: its cells are {kinds}: give a surface of cells 'triangle' or 'quad'")
    split = {"triangle": [[0, 1, 2]], "quad": [[0, 1, 2], [0, 2, 3]]}
    faces = [block.data[:, corners] for block in mesh.cells if block.type in flat for corners in split[block.type]]
    attributes = {name: values for name, values in mesh.point_data.items() if np.ndim(values) in (1, 2)}

    def back(light: Light[Any]) -> Any:
        vertices, triangles, values = light.split()
        return meshio.Mesh(vertices, [("triangle", triangles)], point_data=values)

    return {"vertices": mesh.points, "faces": np.concatenate(faces), "attributes": attributes, "back": back}


def _read_pymeshlab(mesh: Any) -> dict[str, Any]:
    """Reads a mesh of PyMeshLab, or the current one of a set; of its data colours of vertices are carried."""
    import pymeshlab

    current = mesh.current_mesh() if isinstance(mesh, pymeshlab.MeshSet) else mesh
    attributes = {"colors": current.vertex_color_matrix()} if current.has_vertex_color() else {}

    def back(light: Light[Any]) -> Any:
        vertices, triangles, values = light.split()
        colors = {"v_color_matrix": values["colors"].astype(np.float64)} if "colors" in values else {}
        lighter = pymeshlab.Mesh(vertices.astype(np.float64), triangles, **colors)
        if current is mesh:
            return lighter
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(lighter, current.label())
        return meshes

    return {"vertices": current.vertex_matrix(), "faces": current.face_matrix(), "attributes": attributes, "back": back}


def _read_pyvista(mesh: Any) -> dict[str, Any]:
    import pyvista as pv

    if not isinstance(mesh, pv.PolyData):
        raise NeuralMeshError(f"pyvista.{type(mesh).__name__}: not a surface: give PolyData, such as mesh.extract_surface()")
    surface = mesh if mesh.is_all_triangles else mesh.triangulate()
    data = surface.point_data
    roles = {data.active_texture_coordinates_name: "uv", data.active_normals_name: "normals"}
    attributes: dict[str, Any] = {}
    input_names: dict[str, str] = {}
    for name in data.keys():
        values = np.asarray(data[name])
        if values.ndim > 2 or not (np.issubdtype(values.dtype, np.number) or values.dtype == np.bool_):
            continue
        is_colour = values.dtype == np.uint8 and values.ndim == 2 and values.shape[1] in (3, 4)
        role = roles.get(name) or ("colors" if is_colour and "colors" not in input_names else name)
        attributes[role], input_names[role] = values, name
    cells = {name: np.asarray(surface.cell_data[name]) for name in surface.cell_data.keys()}
    # Cell normals are left out, as the result's faces have their own.
    face_values = {name: values for name, values in cells.items() if name != surface.cell_data.active_normals_name}
    is_group = {name: values.ndim == 1 and np.issubdtype(values.dtype, np.integer) for name, values in face_values.items()}
    group_name = next((name for name in face_values if is_group[name] and name.lower() in _GROUP_NAMES), None)

    def back(light: Light[Any]) -> Any:
        vertices, faces, values = light.split()
        lighter = pv.PolyData.from_regular_faces(vertices, faces)
        for role, array in values.items():
            lighter.point_data[input_names.get(role, role)] = array
        if "uv" in values:
            lighter.point_data.active_texture_coordinates = values["uv"]
        if "normals" in values:
            lighter.point_data.active_normals_name = input_names["normals"]
        for name, array in light.face_attributes.items():
            lighter.cell_data[name] = array
        if light.groups is not None:
            # The chosen groups are the one array of the input that is not among the result's face values.
            chosen = next((name for name in face_values if name not in light.face_attributes), group_name or "groups")
            lighter.cell_data[chosen] = light.groups
        return lighter

    fields = {"vertices": np.asarray(surface.points), "faces": surface.regular_faces, "attributes": attributes, "face_values": face_values}
    return {**fields, "groups": None if group_name is None else cells[group_name], "groups_name": group_name, "back": back}

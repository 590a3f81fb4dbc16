"""Triangles with normals and texture coordinates at corners: from Blender, from and to OBJ, and how far a result is from an original."""

from dataclasses import dataclass
from types import SimpleNamespace

import igl
import numpy as np

import surface

# Least distance of a sample from seams, over the diagonal: nearer, the closest point may be across the seam.
NEAR_SEAM = 0.01


@dataclass
class Corners:
    positions: np.ndarray  # vertices x 3
    triangles: np.ndarray  # faces x 3
    normals: np.ndarray  # faces x 3 x 3
    uvs: np.ndarray  # faces x 3 x 2


def read_mesh(mesh):
    """Returns the corners of a mesh of Blender."""
    mesh.calc_loop_triangles()
    loops = get(mesh.loop_triangles, "loops", np.int32, 3)
    normals = get(mesh.corner_normals, "vector", np.float32, 3)
    uvs = get(mesh.uv_layers[0].uv, "vector", np.float32, 2)
    triangles = get(mesh.loop_triangles, "vertices", np.int32, 3)
    return Corners(get(mesh.vertices, "co", np.float32, 3), triangles, normals[loops], uvs[loops])


def get(items, name, kind, width):
    values = np.empty(len(items) * width, kind)
    items.foreach_get(name, values)
    return values.reshape(-1, width)


def write_obj(path, corners):
    """Writes an OBJ in which corners of equal values share them."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners.positions]
    numbers = []
    for word, rows in (("vt", corners.uvs), ("vn", corners.normals)):
        rows = np.round(rows.reshape(-1, rows.shape[-1]), 6)
        values, inverse = np.unique(rows, axis=0, return_inverse=True)
        lines += [f"{word} " + " ".join(f"{x:.7g}" for x in value) for value in values]
        numbers.append(inverse.reshape(-1, 3) + 1)
    for points, uvs, normals in zip(corners.triangles + 1, *numbers):
        lines.append("f " + " ".join(f"{p}/{t}/{n}" for p, t, n in zip(points, uvs, normals)))
    path.write_text("\n".join(lines) + "\n")


def read_obj(path):
    values, faces = {"v": [], "vt": [], "vn": []}, []
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word in values:
            values[word].append([float(x) for x in rest])
        elif word == "f":
            faces.append([[int(number) - 1 for number in corner.split("/")] for corner in rest])
    faces = np.array(faces)
    positions, uvs, normals = (np.array(values[word]) for word in ("v", "vt", "vn"))
    return Corners(positions, faces[..., 0], normals[faces[..., 2]], uvs[faces[..., 1]][..., :2])


def find_seams(corners):
    """Returns edges, n x 2, whose two faces have different texture coordinates there, or that have one face."""
    seen, seams = {}, []
    for face, uvs in zip(corners.triangles.tolist(), corners.uvs):
        for i in range(3):
            ends = sorted([(face[i], tuple(uvs[i])), (face[(i + 1) % 3], tuple(uvs[(i + 1) % 3]))])
            edge = (ends[0][0], ends[1][0])
            values = np.array([end[1] for end in ends])
            if edge not in seen:
                seen[edge] = values
            elif np.abs(seen.pop(edge) - values).max() > 1e-5:
                seams.append(edge)
    return np.array(seams + list(seen), int).reshape(-1, 2)


class Original:
    """An input, with samples on it that are the same for each result."""

    def __init__(self, corners, n_samples):
        self.corners, self.n_samples = corners, n_samples
        self.centre, self.diagonal = surface.find_frame(SimpleNamespace(corners=corners.positions[corners.triangles]))
        self.surface = self.place(corners)
        self.faces, self.weights = self.surface.sample(n_samples, np.random.default_rng(1))
        points = self.surface.interpolate_points(self.faces, self.weights)
        vertices = (corners.positions - self.centre) / self.diagonal
        squared = igl.point_mesh_squared_distance(points, np.ascontiguousarray(vertices), find_seams(corners))[0]
        self.is_clear = np.sqrt(squared) > NEAR_SEAM

    def place(self, corners):
        made = SimpleNamespace(corners=corners.positions[corners.triangles], normals=corners.normals)
        return surface.Surface(made, self.centre, self.diagonal)

    def measure(self, result):
        """Returns mean and largest distance in percent of the diagonal, mean angle in degrees, and the error of coordinates."""
        placed = self.place(result)
        differences = surface.compare(self.surface, placed, self.n_samples)
        faces, weights = self.faces[self.is_clear], self.weights[self.is_clear]
        points = self.surface.interpolate_points(faces, weights) + self.surface.fronts[faces]
        found, places = placed.find_closest_in_front(points)
        blend = lambda uvs, faces, weights: np.einsum("nk,nkd->nd", weights, uvs[faces])  # noqa: E731
        errors = np.linalg.norm(blend(self.corners.uvs, faces, weights) - blend(result.uvs, found, places), axis=1)
        return np.array([differences.mean, differences.max, differences.angle, np.percentile(errors, 95)])

"""Pictures of a mesh or scene from several directions and distances, and their FLIP error."""

import flip_evaluator
import numpy as np
import trimesh
from PIL import Image

import gltf
import pictures
import surface
from measure import count_comparable_faces

# The six directions of `appearance`: azimuth and elevation in degrees.
DIRECTIONS = [(30, 15), (120, 15), (210, 15), (300, 15), (75, 70), (255, -70)]
DISTANCES = (1.0, 2.0)


def to_vector(azimuth, elevation):
    azimuth, elevation = np.radians([azimuth, elevation])
    return np.array([np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)])


def read_mesh(path):
    """Returns the triangles of a mesh, shaded flat in grey, and its number of faces."""
    mesh = trimesh.load(path, process=False)
    corners = np.asarray(mesh.triangles)
    corners = corners[gltf.has_area(corners)]
    normals = gltf.normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    n = len(corners)
    grey = np.full((n, 3, 3), 0.6)
    flat = gltf.Triangles(corners, normals[:, None].repeat(3, axis=1), np.zeros((n, 3, 2)), grey, np.full(n, -1))
    return flat, len(mesh.faces)


class Shots:
    """All pictures of one file."""

    def __init__(self, path, original=None):
        """Draws a file; a result is drawn in the frame of its original."""
        self.asset, read_image = None, lambda material: None
        if path.suffix in (".glb", ".gltf"):
            self.asset = gltf.Asset(path)
            triangles, read_image = self.asset.place_scene(), self.asset.read_base_image
            self.n_faces = count_comparable_faces(original.asset if original else self.asset, self.asset)
        else:
            triangles, self.n_faces = read_mesh(path)
        self.frame = original.frame if original else surface.find_frame(triangles)
        centre, diagonal = self.frame
        triangles.corners = (triangles.corners - centre) / diagonal
        views = [(to_vector(*direction), distance) for direction in DIRECTIONS for distance in DISTANCES]
        self.pictures = list(pictures.draw_triangles(triangles, read_image, views, pictures.add_lights))

    def save(self, path):
        """Writes the first picture."""
        Image.fromarray(self.pictures[0][0]).save(path)

    def flip(self, other):
        """Returns the mean FLIP error of another file's pictures, over the pixels that show either."""

        def error(own, others):
            (one, is_in_one), (two, is_in_two) = own, others
            one, two = [np.ascontiguousarray(picture, dtype=np.float32) / 255 for picture in (one, two)]
            errors = flip_evaluator.evaluate(one, two, "LDR", applyMagma=False)[0]
            return float(np.mean(errors[is_in_one | is_in_two]))

        return float(np.mean([error(*pair) for pair in zip(self.pictures, other.pictures, strict=True)]))

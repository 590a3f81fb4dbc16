"""Measures how far two placed surfaces are apart: distances, and angles between their stored normals."""

from dataclasses import dataclass

import numpy as np
import open3d

import gltf

# The search for the largest distance ends when no other is larger by more than this share, or after so many points.
CLOSE = 1e-4
FARTHEST = 500
# Rounding of single precision, as a share of the diagonal: distances that differ by less are the same.
SINGLES = 1e-6
# How far surfaces move to their front before normals are compared, as a share of the diagonal. Leaves have two sheets at one
# place, one for each side: this finds the one that faces as the sample does.
FRONT = 1e-4


@dataclass
class Differences:
    """Two-sided differences of a result from the original, distances in percent of the original's diagonal."""

    mean: float  # mean of the mean distances in both directions
    max: float  # largest of all samples, vertices and middles of edges, in both directions
    angle: float  # mean angle between normals at samples of the original and their closest points, in degrees


class Surface:
    """Placed triangles in the frame where the original's centre is 0 and its diagonal 1."""

    def __init__(self, triangles, centre, diagonal):
        self.corners = (triangles.corners - centre) / diagonal
        self.normals = triangles.normals
        doubled = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        self.areas = np.linalg.norm(doubled, axis=1)
        self.centres = self.corners.mean(axis=1)
        self.reaches = np.linalg.norm(self.corners - self.centres[:, None], axis=2).max(axis=1)
        self.fronts = FRONT * gltf.normalize(self.normals.mean(axis=1))
        self.tree = build_tree(self.corners)
        self.front_tree = build_tree(self.corners + self.fronts[:, None])

    def sample(self, n_samples, random):
        """Returns faces and barycentric coordinates of samples, one in each of n_samples strips of equal area."""
        reach = np.cumsum(self.areas)
        strips = (np.arange(n_samples) + random.random(n_samples)) / n_samples
        faces = np.minimum(np.searchsorted(reach, strips * reach[-1]), len(reach) - 1)
        root, share = np.sqrt(random.random(n_samples)), random.random(n_samples)
        return faces, np.stack([1 - root, root * (1 - share), root * share], axis=1)

    def find_vertices_and_middles(self):
        """Returns the corners and the middles of the edges, each position once, n x 3."""
        middles = 0.5 * (self.corners + np.roll(self.corners, 1, axis=1))
        return np.unique(np.concatenate([self.corners, middles]).reshape(-1, 3), axis=0)

    def find_closest(self, points, tree):
        """Returns faces and barycentric coordinates of the closest points in one of the trees."""
        found = tree.compute_closest_points(points.astype(np.float32), nthreads=1)
        u, v = found["primitive_uvs"].numpy().astype(float).T
        return found["primitive_ids"].numpy(), np.stack([1 - u - v, u, v], axis=1)

    def interpolate_points(self, faces, weights):
        return np.einsum("nk,nkd->nd", weights, self.corners[faces])

    def measure_distances(self, points):
        """Returns the distances of points (n x 3), too large where the tree, in singles, errs among needles."""
        return np.linalg.norm(self.interpolate_points(*self.find_closest(points, self.tree)) - points, axis=1)

    def find_largest_distance(self, points):
        """Returns the largest distance of points (n x 3) in doubles, of those that seem to be the farthest."""
        largest, distances = 0.0, self.measure_distances(points)
        for index in np.argsort(-distances)[:FARTHEST]:
            if distances[index] <= (1 + CLOSE) * largest + SINGLES:
                break
            largest = max(largest, self.measure_exactly(points[index], distances[index]))
        return largest

    def measure_exactly(self, point, at_most):
        """Returns the distance of a point, which is known to be at most that, from all faces within reach."""
        away = np.linalg.norm(self.centres - point, axis=1) - self.reaches
        a, b, c = np.moveaxis(self.corners[away <= at_most + SINGLES] - point, 1, 0)
        of_edges = min(distances_of_origin(*edge).min() for edge in ((a, b), (b, c), (c, a)))
        normals = np.cross(b - a, c - a)
        # The foot of the perpendicular is inside where it is left of all edges.
        is_inside = np.all([np.sum(np.cross(p, q) * normals, axis=1) >= 0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
        heights = np.abs(np.sum(a * normals, axis=1)) / np.linalg.norm(normals, axis=1)
        return min(of_edges, heights.min(initial=np.inf, where=is_inside), at_most)

    def interpolate_normals(self, faces, weights):
        return gltf.normalize(np.einsum("nk,nkd->nd", weights, self.normals[faces]))


def build_tree(corners):
    """Builds the tree of triangles, n x 3 x 3."""
    tree, soup = open3d.t.geometry.RaycastingScene(nthreads=1), corners.reshape(-1, 3).astype(np.float32)
    tree.add_triangles(soup, np.arange(len(soup), dtype=np.uint32).reshape(-1, 3))
    return tree


def distances_of_origin(a, b):
    """Returns the distances of the origin from segments between points, both n x 3."""
    along = b - a
    share = np.clip(-np.sum(a * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-300), 0, 1)
    return np.linalg.norm(a + share[:, None] * along, axis=1)


def find_frame(triangles):
    """Returns the centre and the diagonal of the bounding box."""
    points = triangles.corners.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low))


def compare(original, result, n_samples):
    """Compares two `Surface`s by n_samples samples on each; samples are the same for each result."""
    random = np.random.default_rng(0)
    means, largest = [], []
    for one, other in ((original, result), (result, original)):
        samples = one.interpolate_points(*one.sample(n_samples, random))
        means.append(other.measure_distances(samples).mean())
        largest.append(other.find_largest_distance(np.concatenate([samples, one.find_vertices_and_middles()])))
    faces, weights = original.sample(n_samples, np.random.default_rng(0))
    points = original.interpolate_points(faces, weights) + original.fronts[faces]
    found = result.find_closest(points, result.front_tree)
    cosines = np.sum(original.interpolate_normals(faces, weights) * result.interpolate_normals(*found), axis=1)
    angle = np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean()
    return Differences(50 * (means[0] + means[1]), 100 * max(largest), float(angle))

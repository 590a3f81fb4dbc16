"""Measures how far two placed surfaces are apart: distances, and angles between their stored normals."""

from dataclasses import dataclass

import igl
import numpy as np

import gltf

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
        self.fronts = FRONT * gltf.normalize(self.normals.mean(axis=1))

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

    def interpolate_points(self, faces, weights):
        return np.einsum("nk,nkd->nd", weights, self.corners[faces])

    def measure_distances(self, points):
        """Returns the distances of points, n x 3."""
        return np.sqrt(find_closest(points, self.corners)[0])

    def find_closest_in_front(self, points):
        """Returns the faces, moved to their front, that lie closest to points (n x 3), and where on them."""
        corners = self.corners + self.fronts[:, None]
        _, faces, closest = find_closest(points, corners)
        return faces, igl.barycentric_coordinates(closest, *np.ascontiguousarray(np.moveaxis(corners[faces], 1, 0)))

    def interpolate_normals(self, faces, weights):
        return gltf.normalize(np.einsum("nk,nkd->nd", weights, self.normals[faces]))


def find_closest(points, corners):
    """Returns squared distances, faces and the points closest on them of points, in doubles; triangles are n x 3 x 3."""
    soup = np.ascontiguousarray(corners.reshape(-1, 3))
    return igl.point_mesh_squared_distance(np.ascontiguousarray(points), soup, np.arange(len(soup)).reshape(-1, 3))


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
        distances = other.measure_distances(np.concatenate([samples, one.find_vertices_and_middles()]))
        means.append(distances[:n_samples].mean())
        largest.append(distances.max())
    faces, weights = original.sample(n_samples, np.random.default_rng(0))
    points = original.interpolate_points(faces, weights) + original.fronts[faces]
    found = result.find_closest_in_front(points)
    cosines = np.sum(original.interpolate_normals(faces, weights) * result.interpolate_normals(*found), axis=1)
    angle = np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean()
    return Differences(50 * (means[0] + means[1]), 100 * max(largest), float(angle))

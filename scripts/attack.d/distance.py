"""Distances of points from a surface, exact up to rounding, which give a lower bound of the largest distance of two surfaces."""

from math import dist
from random import Random

# Largest number of points per surface: vertices, then centers of faces.
MOST_POINTS = 400


def dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def minus(u, v):
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def to_segment(p, a, b):
    u = minus(b, a)
    along = dot(u, u)
    share = min(max(dot(minus(p, a), u) / along, 0.0), 1.0) if along > 0 else 0.0
    away = minus(p, (a[0] + share * u[0], a[1] + share * u[1], a[2] + share * u[2]))
    return dot(away, away) ** 0.5


def to_triangle(p, a, b, c):
    u, v, w = minus(b, a), minus(c, a), minus(p, a)
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    area = uu * vv - uv * uv
    s, t = vv * wu - uv * wv, uu * wv - uv * wu
    rim = min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))
    if area > 1e-14 * uu * vv and s >= 0 and t >= 0 and s + t <= area:
        s, t = s / area, t / area
        away = [w[k] - s * u[k] - t * v[k] for k in range(3)]
        return min(rim, dot(away, away) ** 0.5)
    return rim


def to_surface(point, triangles):
    """Returns the distance of a point to the closest triangle; each has its center and radius."""
    bounds = [dist(point, centre) - reach for _, centre, reach in triangles]
    best = float("inf")
    for i in sorted(range(len(bounds)), key=bounds.__getitem__):
        if bounds[i] >= best:
            break
        best = min(best, to_triangle(point, *triangles[i][0]))
    return best


def with_reach(points, faces):
    found = []
    for face in faces:
        corners = [points[v] for v in face]
        centre = tuple(sum(axis) / 3 for axis in zip(*corners))
        found.append((corners, centre, max(dist(corner, centre) for corner in corners) * (1 + 1e-12)))
    return found


def largest(first, second):
    """Returns a lower bound of the largest distance between two meshes, in either direction."""
    farthest = 0.0
    for (points, faces), other in ((first, second), (second, first)):
        triangles, own = with_reach(*other), with_reach(points, faces)
        some = list(points) + [centre for _, centre, _ in own]
        for point in Random(0).sample(some, min(MOST_POINTS, len(some))):
            farthest = max(farthest, to_surface(point, triangles))
    return farthest

#!/usr/bin/env python3
"""Makes four textured models with real seams, as OBJ with MTL and PNG: planet, vase, terrain, statue.

    scripts/textured_models.py STATUE.ply FOLDER

All but the statue are made of formulas alone; STATUE.ply is any closed mesh (binary PLY), which gets a box-mapped atlas:
each face goes to the chart of its dominant normal. Needs numpy.
"""
import struct
import sys
import zlib
from pathlib import Path

import numpy as np
SIZE = 1024


def read_ply(path):
    """Reads points and triangles of a binary little-endian PLY with float32 x, y, z first and only triangles."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    words = [line.split() for line in head.decode().splitlines()]
    count = {line[1]: int(line[2]) for line in words if line[0] == "element"}
    scalars = [line for line in words if line[0] == "property" and line[1] != "list"]
    assert all(line[1] in ("float", "float32") for line in scalars), "only float properties are read"
    end = 4 * len(scalars) * count["vertex"]
    points = np.frombuffer(body[:end], "<f4").reshape(count["vertex"], -1)[:, :3]
    faces = np.frombuffer(body[end:], np.dtype([("n", "u1"), ("corners", "<i4", 3)]), count["face"])
    assert (faces["n"] == 3).all(), "only triangles are read"
    return points.astype(float), faces["corners"].astype(np.int64)


def write_png(path, rgb):
    """Writes height x width x 3 values of 0 to 1."""
    rows = (np.clip(rgb, 0, 1) * 255 + 0.5).astype(np.uint8)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def write_obj(folder, name, points, uvs, faces, corners, texture):
    """Writes points (n x 3), uvs (m x 2, v upwards), faces and corners (n_faces x 3: points and uvs), and the texture."""
    write_png(folder / f"{name}.png", texture)
    (folder / f"{name}.mtl").write_text(f"newmtl {name}\nKd 1 1 1\nmap_Kd {name}.png\n")
    lines = [f"mtllib {name}.mtl"]
    lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in points]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in uvs]
    lines += [f"usemtl {name}"]
    lines += ["f " + " ".join(f"{p + 1}/{t + 1}" for p, t in zip(face, uv)) for face, uv in zip(faces, corners)]
    (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")


def waves(points, seed, octaves=6, frequency=1.5):
    """Returns 3-D noise at each point, about -1 to 1, as a sum of plane waves."""
    random = np.random.default_rng(seed)
    value, total = np.zeros(len(points)), 0.0
    for octave in range(octaves):
        for _ in range(5):
            direction = random.normal(size=3)
            direction *= frequency * 2**octave / np.linalg.norm(direction)
            value += 0.6**octave * np.sin(points @ direction * 2 * np.pi + random.uniform(0, 2 * np.pi))
        total += 2.2 * 0.6**octave
    return value / total


def ramp(value, stops):
    """Interpolates colours between stops (value, red, green, blue)."""
    stops = np.array(stops)
    return np.stack([np.interp(value, stops[:, 0], stops[:, k]) for k in (1, 2, 3)], axis=-1)


def grid_faces(rows, columns, wrap):
    """Triangles over rows + 1 x columns + 1 places of a grid: their points, which join at the end where `wrap`, and places."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    place = lambda i, j: i * (columns + 1) + j
    quads = np.stack([place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)], axis=-1).reshape(-1, 4)
    corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    row, column = np.divmod(corners, columns + 1)
    points = row * columns + column % columns if wrap else corners
    return points, corners


def lathe(points, corners):
    """Drops the degenerate triangles of a grid at poles."""
    a, b, c = points.T
    keep = (a != b) & (b != c) & (c != a)
    return points[keep], corners[keep]


def texels():
    """Returns u and v of the centers of all pixels, v upwards, SIZE x SIZE each."""
    middle = (np.arange(SIZE) + 0.5) / SIZE
    return np.meshgrid(middle, 1 - middle)


def planet(folder):
    rows, columns = 80, 160
    def on_sphere(u, v):
        azimuth, polar = 2 * np.pi * u, np.pi * (1 - v)
        return np.stack([np.sin(polar) * np.cos(azimuth), np.cos(polar), -np.sin(polar) * np.sin(azimuth)], axis=-1)
    v, u = np.meshgrid(np.linspace(1, 0, rows + 1), np.arange(columns) / columns, indexing="ij")
    directions = on_sphere(u, v).reshape(-1, 3)
    height = waves(directions, 1, 5, 0.6)
    points = directions * (1 + 0.12 * np.maximum(height, -0.1))[:, None]
    faces, corners = grid_faces(rows, columns, True)
    # The points of a pole are merged.
    last = rows * columns
    faces[faces < columns] = 0
    faces[faces >= last] = last
    faces, corners = lathe(faces, corners)
    used, faces = np.unique(faces, return_inverse=True)
    v, u = np.meshgrid(np.linspace(1, 0, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    pu, pv = texels()
    value = waves(on_sphere(pu, pv).reshape(-1, 3), 1, 5, 0.6).reshape(SIZE, SIZE)
    stops = [(-0.6, 0.02, 0.08, 0.3), (-0.1, 0.1, 0.35, 0.6), (-0.08, 0.85, 0.78, 0.5), (0.05, 0.2, 0.5, 0.15), (0.3, 0.45, 0.3, 0.15), (0.5, 0.95, 0.95, 0.97)]
    uvs = np.stack([u.ravel(), v.ravel()], axis=-1)
    write_obj(folder, "planet", points[used], uvs, faces.reshape(-1, 3), corners, ramp(value, stops))


def vase(folder):
    rows, columns = 120, 96
    profile = lambda t: 0.35 + 0.18 * np.sin(2.2 * np.pi * t + 0.4) + 0.05 * np.cos(7 * np.pi * t)
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.arange(columns) / columns, indexing="ij")
    radius = profile(v) * (1 + 0.04 * np.cos(12 * 2 * np.pi * u) * np.sin(np.pi * v) ** 2)
    points = np.stack([radius * np.cos(2 * np.pi * u), 1.6 * v, -radius * np.sin(2 * np.pi * u)], axis=-1).reshape(-1, 3)
    faces, corners = grid_faces(rows, columns, True)
    faces, corners = faces[:, [0, 2, 1]], corners[:, [0, 2, 1]]
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    pu, pv = texels()
    band = 0.5 + 0.5 * np.sin(2 * np.pi * (9 * pv + 0.35 * np.sin(2 * np.pi * 8 * pu)))
    dots = (np.hypot((pu * 24) % 1 - 0.5, (pv * 24) % 1 - 0.5) < 0.28) & (np.abs(pv - 0.5) < 0.14)
    colour = ramp(np.round(band * 3) / 3, [(0, 0.12, 0.12, 0.35), (0.4, 0.75, 0.3, 0.15), (0.7, 0.92, 0.8, 0.55), (1, 0.15, 0.45, 0.5)])
    colour[dots] = (0.95, 0.9, 0.8)
    write_obj(folder, "vase", points, np.stack([u.ravel(), v.ravel()], axis=-1), faces, corners, colour)


def terrain(folder):
    n = 128
    z, x = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    flat = lambda x, z: np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=-1)
    height = waves(flat(x, z), 4, 6, 1.3)
    points = np.stack([x.ravel(), 0.18 * height, z.ravel()], axis=-1)
    faces, corners = grid_faces(n, n, False)
    pu, pv = texels()
    value = waves(flat(pu, 1 - pv), 4, 6, 1.3).reshape(SIZE, SIZE)
    light = np.clip(0.75 + 14 * (np.roll(value, 2, 1) - value), 0.3, 1.15)
    stops = [(-0.6, 0.1, 0.25, 0.45), (-0.25, 0.2, 0.45, 0.5), (-0.2, 0.8, 0.72, 0.5), (0.0, 0.3, 0.5, 0.2), (0.3, 0.4, 0.35, 0.3), (0.5, 0.95, 0.95, 0.97)]
    uvs = np.stack([x.ravel(), 1 - z.ravel()], axis=-1)
    write_obj(folder, "terrain", points, uvs, faces, corners, ramp(value, stops) * light[..., None])


def statue(folder, path):
    points, faces = read_ply(path)
    low, side = points.min(axis=0), np.ptp(points, axis=0).max()
    unit = (points - low) / side
    normals = np.cross(unit[faces[:, 1]] - unit[faces[:, 0]], unit[faces[:, 2]] - unit[faces[:, 0]])
    axis = np.abs(normals).argmax(axis=1)
    chart = 2 * axis + (np.take_along_axis(normals, axis[:, None], 1)[:, 0] < 0)
    # Two by three charts, each over the whole box seen along its axis, with a margin.
    uvs, corners = {}, np.zeros_like(faces)
    for f, face in enumerate(faces):
        for k, p in enumerate(face):
            corners[f, k] = uvs.setdefault((chart[f], p), len(uvs))
    across = lambda c: [(1, 2), (0, 2), (0, 1)][c // 2]
    place = lambda c, p: ((c % 3 + 0.02 + 0.96 * unit[p, across(c)[0]]) / 3, (c // 3 + 0.02 + 0.96 * unit[p, across(c)[1]]) / 2)
    coordinates = np.array([place(c, p) for c, p in uvs])
    pu, pv = texels()
    column, row = np.minimum((3 * pu).astype(int), 2), np.minimum((2 * pv).astype(int), 1)
    inner = np.stack([(3 * pu - column - 0.02) / 0.96, (2 * pv - row - 0.02) / 0.96], axis=-1)
    where = np.zeros((SIZE, SIZE, 3))
    for c in range(6):
        is_chart = (column == c % 3) & (row == c // 3)
        flat = np.full((is_chart.sum(), 3), 0.37 * (c + 1))
        flat[:, across(c)] = inner[is_chart]
        where[is_chart] = flat
    value = waves(where.reshape(-1, 3), 8, 6, 1.5).reshape(SIZE, SIZE)
    veins = np.abs(waves(where.reshape(-1, 3), 9, 4, 2.0).reshape(SIZE, SIZE))
    colour = ramp(value, [(-0.6, 0.5, 0.32, 0.25), (0, 0.85, 0.75, 0.62), (0.6, 0.95, 0.93, 0.88)])
    colour *= np.clip(0.35 + 9 * veins, 0, 1)[..., None]
    write_obj(folder, "statue", points, coordinates, faces, corners, colour)


if __name__ == "__main__":
    out = Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    planet(out)
    vase(out)
    terrain(out)
    statue(out, Path(sys.argv[1]))

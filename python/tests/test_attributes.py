"""Attributes and groups: seams stay seams, and values keep their names and types."""

from __future__ import annotations

import numpy as np
import pytest

import neural_mesh as nm
from conftest import grid, torus


def test_corner_texture_coordinates_keep_seam() -> None:
    vertices, faces, uv = grid(40)
    light = nm.simplify((vertices, faces), ratio=0.1, attributes={"uv": uv})
    corners = light.corners("uv")
    chart = corners[..., 0] > 1.5
    # Every face has all corners in one chart, at the chart's coordinates.
    assert (chart.all(1) | ~chart.any(1)).all() and 0.3 < chart.mean() < 0.7
    expected = light.vertices[light.faces][..., :2] + 2.0 * chart[..., None]
    assert np.abs(corners - expected).max() < 0.03


def test_duplicate_vertices_form_seam_without_hole() -> None:
    vertices, faces, uv = grid(30)
    # Formats without corner values store one vertex per set of values.
    rows, of_corner = np.unique(np.concatenate([vertices[faces].reshape(-1, 3), uv.reshape(-1, 2)], 1), axis=0, return_inverse=True)
    split_faces = of_corner.reshape(-1, 3)
    light = nm.simplify((rows[:, :3], split_faces), ratio=0.2, attributes={"uv": rows[:, 3:]})
    assert light.report["cleaned"]["welded_vertices"] == len(rows) - len(vertices)
    v, f, values = light.split()
    assert len(v) > len(light.vertices) and len(f) == len(light.faces)
    np.testing.assert_array_equal(values["uv"][f], light.corners("uv"))
    np.testing.assert_array_equal(v[f], light.vertices[light.faces])


def test_attributes_keep_names_types_and_shapes() -> None:
    vertices, faces = torus(60, 40)
    attributes = {
        "colors": (vertices * 60 + 120).astype(np.uint8),
        "normals": (vertices / np.linalg.norm(vertices, axis=1, keepdims=True)).astype(np.float64),
        "heat": vertices[:, 0].astype(np.float64),
        "label": (vertices[:, 1] > 0).astype(np.int64) * 7,
    }
    light = nm.simplify((vertices, faces), ratio=0.3, attributes=attributes)
    assert list(light.attributes) == list(attributes)
    for name, values in attributes.items():
        result = light.attributes[name]
        assert result.dtype == values.dtype and result.ndim == values.ndim, name
    assert set(light.attributes["label"]) == {0, 7}
    corners = light.corners("heat")
    assert np.abs(corners - light.vertices[light.faces][..., 0]).max() < 0.05
    colours = light.corners("colors").astype(float)
    assert np.abs(colours - (light.vertices[light.faces] * 60 + 120)).max() < 8


def test_groups_keep_numbers_and_borders() -> None:
    vertices, faces = torus(60, 40)
    groups = np.where(vertices[faces][..., 0].mean(1) > 0, 40, -3)
    light = nm.simplify((vertices, faces), ratio=0.2, groups=groups)
    assert light.groups is not None and set(light.groups) == {40, -3}
    side = np.where(light.vertices[light.faces][..., 0].mean(1) > 0, 40, -3)
    assert (side == light.groups).mean() > 0.97


def test_ignored_attributes_are_absent() -> None:
    vertices, faces, uv = grid(20)
    light = nm.simplify((vertices, faces), ratio=0.3, attributes={"uv": uv, "heat": vertices[:, 0]}, ignore=["uv"])
    assert list(light.attributes) == ["heat"]


def test_duplicate_roles_are_rejected() -> None:
    vertices, faces = torus(20, 12)
    with pytest.raises(nm.NeuralMeshError, match="another attribute of that kind"):
        nm.simplify((vertices, faces), ratio=0.5, attributes={"color": vertices, "colors": vertices})


def test_bare_mesh_has_no_attributes() -> None:
    light = nm.simplify(torus(20, 12), ratio=0.5)
    assert light.wedges is None and not light.attributes and light.groups is None
    with pytest.raises(nm.NeuralMeshError, match="the mesh has no such attribute"):
        light.corners("uv")
    assert light.split()[2] == {}

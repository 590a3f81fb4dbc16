"""Batches of meshes or clouds, packed into one: lists, `[B, n, 3]` with one connectivity, or a `batch` vector."""

from __future__ import annotations

from typing import Any, NamedTuple

import torch

from .._native import NeuralMeshError


class Packed(NamedTuple):
    """Meshes after each other; faces name vertices of the whole."""

    vertices: Any
    """n x 3, floating-point."""
    faces: Any
    """n_faces x 3, int64; none for clouds."""
    batch: Any
    """Mesh of each vertex, ascending: n, int64."""
    n_meshes: int


def pack_meshes(vertices: Any, faces: Any, batch: Any = None) -> Packed:
    """Packs a mesh, a list of meshes, or `[B, n, 3]` vertices with faces that all share; clouds, if there are no faces.

    Raises `NeuralMeshError` for wrong shapes, types, indices, or numbers that are not finite."""
    if faces is None:
        return _pack_clouds(vertices, batch)
    if isinstance(vertices, (list, tuple)):
        if batch is not None or not isinstance(faces, (list, tuple)) or len(faces) != len(vertices):
            raise NeuralMeshError(f"faces: give a list of as many as vertices ({len(vertices)}), and no batch")
        checked = [_check_mesh(v, f) for v, f in zip(vertices, faces, strict=True)]
        sizes = torch.tensor([len(v) for v, _ in checked])
        starts = (sizes.cumsum(0) - sizes).tolist()
        faces = torch.cat([f + start for (_, f), start in zip(checked, starts, strict=True)])
        vertices = torch.cat([v for v, _ in checked])
        return Packed(vertices, faces, torch.arange(len(sizes)).repeat_interleave(sizes).to(faces.device), len(sizes))
    if vertices.dim() == 3:
        if batch is not None:
            raise NeuralMeshError("batch: vertices of shape B x n x 3 are a batch already: leave it out")
        n_meshes, n = vertices.shape[:2]
        _, faces = _check_mesh(vertices.reshape(-1, 3), faces, n)
        order = torch.arange(n_meshes, device=vertices.device)
        faces = (faces + n * order[:, None, None]).reshape(-1, 3)
        return Packed(vertices.reshape(-1, 3), faces, order.repeat_interleave(n), n_meshes)
    vertices, faces = _check_mesh(vertices, faces)
    if batch is None:
        return Packed(vertices, faces, torch.zeros(len(vertices), dtype=torch.int64, device=vertices.device), 1)
    batch = _check_batch(vertices, batch)
    if len(faces) > 0 and bool((batch[faces].amin(1) != batch[faces].amax(1)).any()):
        raise NeuralMeshError("faces: a face joins vertices of two meshes of the batch")
    return Packed(vertices, faces, batch, int(batch[-1]) + 1)


def _pack_clouds(vertices: Any, batch: Any) -> Packed:
    """Packs points without faces; raises `NeuralMeshError` as `pack_meshes` does, and for a cloud of one or two points."""
    if isinstance(vertices, (list, tuple)):
        if batch is not None or len(vertices) == 0:
            raise NeuralMeshError("vertices: give a list of at least one cloud, and no batch")
        sizes = torch.tensor([len(_check_points(points)) for points in vertices], device=vertices[0].device)
        vertices, batch = torch.cat([*vertices]), torch.arange(len(sizes), device=sizes.device).repeat_interleave(sizes)
    elif vertices.dim() == 3:
        if batch is not None:
            raise NeuralMeshError("batch: vertices of shape B x n x 3 are a batch already: leave it out")
        n_clouds, n = vertices.shape[:2]
        vertices, batch = _check_points(vertices.reshape(-1, 3)), torch.arange(n_clouds, device=vertices.device).repeat_interleave(n)
    elif batch is None:
        batch = torch.zeros(len(_check_points(vertices)), dtype=torch.int64, device=vertices.device)
    else:
        batch = _check_batch(_check_points(vertices), batch)
    sizes = torch.bincount(batch, minlength=1)
    if int(sizes.min()) < 3:
        raise NeuralMeshError(f"vertices: a cloud of {int(sizes.min())} points: a surface needs at least three")
    return Packed(vertices, None, batch, len(sizes))


def _check_batch(vertices: Any, batch: Any) -> Any:
    """Returns the mesh of each vertex as int64, after checks."""
    batch = torch.as_tensor(batch, device=vertices.device)
    if batch.shape != (len(vertices),) or batch.is_floating_point() or len(batch) == 0:
        raise NeuralMeshError(f"batch: a tensor of shape {tuple(batch.shape)}, {batch.dtype}: give the mesh of each of {len(vertices)} vertices")
    if bool((batch[1:] < batch[:-1]).any()) or int(batch[0]) < 0:
        raise NeuralMeshError("batch: give the vertices of one mesh after those of another: numbers from 0, ascending")
    return batch.long()


def _check_mesh(vertices: Any, faces: Any, n: int | None = None) -> tuple[Any, Any]:
    """Returns the vertices, and the faces as int64 on their device, after checks; `n` is the number of vertices that faces may name."""
    _check_points(vertices)
    faces = torch.as_tensor(faces, device=vertices.device)
    if faces.dim() != 2 or faces.shape[1] != 3 or faces.is_floating_point() or faces.is_complex():
        raise NeuralMeshError(f"faces: a tensor of shape {tuple(faces.shape)}, {faces.dtype}: give m x 3 whole numbers")
    n = len(vertices) if n is None else n
    if len(faces) == 0:
        raise NeuralMeshError("faces: there are none: leave them out for a cloud of points")
    least, most = (int(x) for x in faces.aminmax())
    if least < 0 or most >= n:
        raise NeuralMeshError(f"faces: one names vertex {least if least < 0 else most}, but there are {n}, from 0")
    return vertices, faces.long()


def _check_points(vertices: Any) -> Any:
    """Returns the vertices, after checks."""
    if vertices.dim() != 2 or vertices.shape[1] != 3 or not vertices.is_floating_point():
        raise NeuralMeshError(f"vertices: a tensor of shape {tuple(vertices.shape)}, {vertices.dtype}: give n x 3 floating-point numbers")
    if not bool(vertices.isfinite().all()):
        raise NeuralMeshError("vertices: a number is not finite: remove such vertices first")
    return vertices

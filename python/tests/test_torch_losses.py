"""Losses of PyTorch: values of the library's examples, naive twins, and gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh.torch as nmt  # noqa: E402
from conftest import torus  # noqa: E402
from neural_mesh.torch import losses  # noqa: E402

DOUBLE = torch.float64


def double(values: Any) -> Any:
    return torch.tensor(values, dtype=DOUBLE)


def check(function: Any, *given: Any) -> float:
    """Returns the value, after comparing the gradient with differences."""
    leaves = [double(x).requires_grad_() for x in given]
    assert torch.autograd.gradcheck(function, leaves)
    return float(function(*leaves).detach())


def soup(n_points: int, n_faces: int, seed: int) -> tuple[Any, Any, Any]:
    """Returns random points, random triangles over them with ascending corners, and probabilities."""
    random = np.random.default_rng(seed)
    faces = np.sort(np.array([random.choice(n_points, 3, replace=False) for _ in range(n_faces)]), axis=1)
    return double(random.random((n_points, 3))), torch.from_numpy(faces), double(random.random(n_faces))


def pairs_of(found: Any) -> list[list[int]]:
    return found.T.tolist()


def all_pairs(n: int) -> Any:
    i, j = torch.meshgrid(torch.arange(n), torch.arange(n), indexing="ij")
    return torch.stack([i[i != j], j[i != j]])


# Values of the examples in `crates/network/src/loss`.


def test_values_of_the_library() -> None:
    line = double([[0.0, 0, 0], [1, 0, 0], [5, 0, 0], [7, 0, 0]])
    assert check(lambda p: losses.probabilistic_chamfer(line, line[[0, 2]], p), [0.5, 0.5]) == 2.5
    three = double([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    nearest = nmt.nearest_to(three, three[:1], 3)
    assert check(lambda p: losses.coverage_of_samples(three, three[:1], nearest, p), [0.5] * 3) == (0.25 * 1 + 0.25 * 4) / 4
    kappa = double([0.0, 0.2])
    assert check(lambda p: losses.curvature_of_samples(kappa, kappa, torch.tensor([[0, 1], [1, 0]]), p), [1.0, 0.5]) == pytest.approx(1)
    path = torch.tensor([[0, 1, 1, 2], [1, 0, 2, 1]])
    assert check(lambda s: losses.smoothness(s, path), [1.0, 4.0, 4.0]) == 4.5
    corner, face = double([[0.0, 0, 0], [3, 0, 0], [0, 3, 0]]), torch.tensor([[0, 1, 2]])
    assert check(lambda p: losses.forward_distance(corner, face, double([[1.0, 1, 2], [9, 9, 9]]), p), [0.25]) == 1.0
    near = torch.tensor([[1, 0]]), double([[0.0, 2.0]])
    assert check(lambda p: losses.coverage(near, 8.0, p), [0.5, 0.5]) == 0.5 * 0.5 * 2 + 0.25 * 8
    at_boundary, edges = torch.tensor([False, True, True, True, True]), torch.tensor([[0, 1, 2], [0, 3, 4]])
    assert check(lambda p: losses.closure(edges, at_boundary, p), [0.5, 1.0]) == 0.5 / 4
    # The empty mesh has no slope: the quotient jumps there.
    assert losses.closure(edges, at_boundary, double([0.0, 0.0])) == 1.0
    labels = torch.tensor([True, False])
    assert check(lambda p: losses.quotient_agreement(labels, p, 0.0), [0.5, 0.5]) == pytest.approx(np.log(2))
    conflicts = torch.tensor([[0, 0, 1], [1, 2, 0]])
    assert check(lambda p: losses.conflicts_by_count(conflicts, p), [0.5, 0.25, 1.0, 1.0]) == (0.5 * 2 + 0.25) / 4
    assert check(lambda p: losses.conflicts_by_pair(conflicts[:, [0, 2]], p), [0.5, 0.25]) == 0.125
    logs = losses.log_errors(double([2.0]), double([0.5]), double([1.0]))
    torch.testing.assert_close(logs, double([np.log(0.5), 0.0, np.log(0.5)]))
    assert losses.total({"forward": (1.0, 2.0), "collision": (0.5, 4.0)}) == 4.0


def test_conflicts_of_the_library() -> None:
    both = torch.tensor([[0, 1], [1, 0]])
    points = double([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1.5, 1], [1.5, 1, 1]])
    assert pairs_of(losses.collisions(points, torch.tensor([[0, 1, 2], [3, 4, 5]]), both)) == [[1, 0]]
    assert pairs_of(losses.collisions(points, torch.tensor([[0, 1, 2], [0, 1, 4]]), both)) == []
    square = double([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.05]])
    crossed, apart = torch.tensor([[0, 1, 2], [0, 1, 3]]), torch.tensor([[0, 1, 2], [0, 2, 3]])
    assert pairs_of(losses.edge_crossings(square, crossed, both)) == [[0, 1], [1, 0]]
    assert pairs_of(losses.edge_crossings(square, apart, both)) == []
    assert pairs_of(losses.overlaps(square * double([1.0, 1, 0]), crossed, both)) == [[0, 1], [1, 0]]
    assert pairs_of(losses.overlaps(square * double([1.0, 1, 0]), apart, both)) == []


# Naive twins.


def test_chamfer_and_forward_distance_one_by_one() -> None:
    points, faces, p = soup(30, 20, 1)
    samples = points[::3] + 0.01
    squared = torch.cdist(points, samples).square()
    q = p[:10]
    naive = (q * squared.amin(0)).sum() + (q[squared.argmin(1)] * squared.amin(1)).sum()
    torch.testing.assert_close(losses.probabilistic_chamfer(points, samples, q), naive)
    centers, original = points[faces].mean(1), points + 0.1
    naive = (p * torch.cdist(centers, original).square().amin(1)).mean()
    torch.testing.assert_close(losses.forward_distance(points, faces, original, p), naive)


def test_reverse_distance_one_by_one() -> None:
    points, faces, p = soup(12, 8, 2)
    original, k = points + 0.05, 3
    ys, centers = losses.spread_points(points, faces, 4), points[faces].mean(1)
    parts = []
    for t in range(len(faces)):
        for y in ys[t]:
            others = sorted((float((centers[u] - y).square().sum()), u) for u in range(len(faces)) if u != t)[:k]
            replaced = sum(p[u] * d for d, u in others) / k
            parts.append(p[t] * (original - y).square().sum(1).min() + (1 - p[t]) * replaced)
    torch.testing.assert_close(losses.reverse_distance(points, faces, original, p, 4, k), torch.stack(parts).mean())
    assert float(losses.reverse_distance(points, faces, original, 0 * p, 4, k)) == 0
    assert check(lambda p: losses.reverse_distance(points, faces, original, p, 4, k), p.tolist()) > 0


def test_coverage_and_closure_over_all_subsets() -> None:
    """The expected values equal the sums over all subsets of kept faces."""
    points, faces, p = soup(6, 5, 3)
    surface = double(np.random.default_rng(4).random((7, 3)))
    near = losses.near_triangles(points, faces, surface, 5)
    edges = torch.tensor([[0, 1, 2], [0, 3, 4], [0, 5, 1], [5, 3, 6], [0, 2, 6]])
    at_boundary = torch.tensor([False, True, False, False, True, False, True])
    distances = torch.full((7, 5), 0.0, dtype=DOUBLE).scatter(1, near[0], near[1])
    covered = wrong = used = 0.0
    for bits in range(32):
        kept = torch.tensor([bool(bits >> i & 1) for i in range(5)])
        chance = torch.where(kept, p, 1 - p).prod()
        covered += chance * (distances[:, kept].amin(1) if bits else torch.full((7,), 9.0, dtype=DOUBLE)).mean()
        counts = torch.bincount(edges[kept].reshape(-1), minlength=7)
        wrong += chance * torch.where(at_boundary, counts > 1, (counts == 1) | (counts > 2)).sum()
        used += chance * (counts > 0).sum()
    torch.testing.assert_close(losses.coverage(near, 9.0, p), covered)
    torch.testing.assert_close(losses.closure(edges, at_boundary, p), wrong / used)
    check(lambda p: losses.closure(edges, at_boundary, p), p.tolist())


def test_distances_to_triangles_by_dense_samples() -> None:
    points, faces, _ = soup(9, 6, 5)
    surface = double(np.random.default_rng(6).random((10, 3)) * 2 - 0.5)
    _, squared = losses.near_triangles(points, faces, surface, 6)
    dense = losses.spread_points(points, faces, 40_000).reshape(-1, 3)
    naive = torch.stack([(dense - x).square().sum(1).min() for x in surface])
    torch.testing.assert_close(squared[:, 0], naive, atol=1e-3, rtol=1e-2)
    assert bool((squared[:, 0] <= naive + 1e-9).all())


def passes_through(a: Any, b: Any) -> bool:
    """Solves for the point where an edge of triangle `a` meets the plane of `b`, and tests its barycentric weights."""
    normal = np.cross(b[1] - b[0], b[2] - b[0])
    for p, q in ((a[0], a[1]), (a[1], a[2]), (a[2], a[0])):
        across = normal @ (q - p)
        if abs(across) < 1e-12:
            continue
        t = normal @ (b[0] - p) / across
        if 0 < t < 1:
            x, basis = p + t * (q - p) - b[0], np.stack([b[1] - b[0], b[2] - b[0]], 1)
            u, v = np.linalg.lstsq(basis, x, rcond=None)[0]
            if u > 1e-9 and v > 1e-9 and u + v < 1 - 1e-9:
                return True
    return False


def test_collisions_one_by_one() -> None:
    points, faces, _ = soup(40, 30, 7)
    x, f = points.numpy(), faces.numpy()
    naive = [[t, u] for t in range(30) for u in range(30) if len({*f[t], *f[u]}) == 6 and passes_through(x[f[t]], x[f[u]])]
    found = [[t, u] for t, u in pairs_of(losses.collisions(points, faces, all_pairs(30))) if len({*f[t], *f[u]}) == 6]
    assert found == naive and len(naive) > 20


def test_nearest_points_one_by_one() -> None:
    random = np.random.default_rng(8)
    # Clumps of very different density, an outlier, and points at one position.
    points = np.concatenate([random.normal(size=(300, 3)), random.normal(size=(300, 3)) * 1e-3 + 4, [[90.0, 0, 0]], np.zeros((5, 3))])
    x = torch.from_numpy(points.astype(np.float32))
    squared = sum((x[:, None, axis] - x[None, :, axis]).square() for axis in range(3))
    for k in (1, 7, 20):
        naive = torch.from_numpy(np.lexsort((np.broadcast_to(np.arange(len(x)), squared.shape), squared.numpy()), axis=1)[:, : k + 1].copy())
        assert torch.equal(squared.gather(1, nmt.nearest_to(x, x, k + 1)), squared.gather(1, naive))
        others = nmt.nearest_neighbours(x, k)
        assert bool((others != torch.arange(len(x))[:, None]).all())
    few = nmt.nearest_neighbours(x[:3], 5)
    assert few.shape == (3, 5) and bool((few[:, 2:] == -1).all()) and bool((few[:, :2] >= 0).all())
    batch = torch.arange(len(x)) // 303
    apart = nmt.nearest_to(x, x, 4, batch, batch)
    assert torch.equal(batch[apart], batch[:, None].expand(-1, 4))


def test_point_curvature() -> None:
    i = torch.arange(100)
    plane = torch.stack([i % 10, i // 10, 0 * i], 1).double()
    assert losses.point_curvature(plane).abs().max() < 1e-6
    v, _ = torus(40, 30, np.float64)
    curvature = losses.point_curvature(torch.from_numpy(v))
    assert bool(((curvature >= 0) & (curvature <= 1 / 3)).all()) and curvature.max() > 0


def test_surface_points_are_even() -> None:
    v, f = (torch.from_numpy(x) for x in torus(20, 14, np.float64))
    torch.manual_seed(1)
    points = losses.surface_points(v, f, 20_000)
    a, b, c = v[f.long()].unbind(1)
    area = torch.linalg.cross(b - a, c - a).norm(dim=1)
    expected = (area[:, None] * (a + b + c) / 3).sum(0) / area.sum()
    assert (points.mean(0) - expected).abs().max() < 0.02


def test_objective_falls_end_to_end() -> None:
    torch.manual_seed(0)
    v, f = (torch.from_numpy(x) for x in torus(20, 14))
    layer = nmt.Simplifier(nmt.PointSampler(3, 2, 8), nmt.EdgePredictor(8, 8, 8), nmt.FaceClassifier(2, 8))
    optimizer, values = torch.optim.Adam(layer.parameters(), lr=0.02), []
    for step in range(120):
        terms = losses.objective_terms(layer(v, f, 0.3, seed=step % 4), v, f)
        loss = losses.total(terms)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        values.append(float(loss.detach()))
    assert {"sampler", "smoothness", "forward", "coverage", "closure", "collision", "crossing", "overlap", "agreement"} == set(terms)
    assert np.mean(values[-5:]) < 0.5 * np.mean(values[:5])
    printed = losses.objective_terms(layer(v, f, 0.3, seed=1), v, f, losses.PRINTED)
    assert {"sampler", "forward", "reverse", "collision", "crossing", "overlap"} == set(printed)
    losses.total(printed).backward()

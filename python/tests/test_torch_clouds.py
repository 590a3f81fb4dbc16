"""The layer of PyTorch on clouds of points: stars, winding, noise, holes, places, results, batches, gradients, tiny clouds."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import neural_mesh as nm  # noqa: E402
import neural_mesh.torch as nmt  # noqa: E402
from conftest import MESHES, torus  # noqa: E402
from neural_mesh.torch import _closing, _clouds, _placing, _smoothing, losses  # noqa: E402
from neural_mesh.torch._regions import choose_manifold  # noqa: E402


@pytest.fixture(scope="module")
def layer() -> Any:
    return nmt.Simplifier.from_weights("paper-open")


def sphere(n: int, center: float = 0.0) -> Any:
    """Returns points of a unit sphere along a spiral."""
    i = np.arange(n) + 0.5
    z, turn = 1 - 2 * i / n, i * np.pi * (1 + 5**0.5)
    r = np.sqrt(1 - z * z)
    return torch.from_numpy(np.stack([r * np.cos(turn), r * np.sin(turn), z], 1).astype(np.float32) + np.float32(center))


def half_edges(faces: Any) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for face in faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True)]


def open_share(faces: Any) -> float:
    """Returns the share of edges without two faces that are wound alike."""
    found = half_edges(faces)
    assert len(set(found)) == len(found)
    sides = set(found)
    return sum((b, a) not in sides for a, b in sides) / len({frozenset(side) for side in sides})


def volume(vertices: Any, faces: Any) -> float:
    a, b, c = vertices.detach()[faces].double().unbind(1)
    return float((a * torch.linalg.cross(b, c)).sum() / 6)


def test_stars_are_those_of_empty_circles() -> None:
    """In a plane, all three corners agree on the Delaunay triangles, found here by testing every circle."""
    random = np.random.default_rng(3)
    points = torch.from_numpy(np.concatenate([random.random((40, 2)), np.zeros((40, 1))], 1))
    triangles, votes, nearest = nmt._clouds.star_triangles(points)
    flat = _clouds._jitter(points, nearest, None)[:, :2].numpy()
    naive = set()
    for i, j, k in itertools.combinations(range(40), 3):
        a, b, c = flat[[i, j, k]]
        center = np.linalg.solve(2 * np.array([b - a, c - a]), np.array([b @ b - a @ a, c @ c - a @ a]))
        others = np.delete(flat, [i, j, k], axis=0)
        # Beyond the cloud, circles are larger than the neighbourhoods.
        if ((others - center) ** 2).sum(1).min() > ((a - center) ** 2).sum() and ((center - 0.5) ** 2).max() < 0.12:
            naive.add((i, j, k))
    agreed = {tuple(t) for t in triangles[votes == 3].tolist()}
    assert len(naive) > 20 and len(naive & agreed) >= 0.95 * len(naive)
    assert all(tuple(sorted(t)) == tuple(t) for t in triangles.tolist())


def test_pairs_agree_along_the_surest_ones() -> None:
    """Of two rings of nodes with random signs, each is one component, in which wrong pairs that come last change nothing."""
    random = np.random.default_rng(1)
    signs = torch.from_numpy(random.choice([-1.0, 1.0], 600))
    own = torch.arange(600)
    ends = torch.stack([own, own - own % 300 + (own + 1) % 300])[:, torch.from_numpy(random.permutation(600))]
    turns = signs[ends[0]] * signs[ends[1]]
    wrong = torch.stack([own[:50], own[100:150]])
    found, component = _clouds._turn_alike(torch.cat([ends, wrong], 1), torch.cat([turns, -signs[wrong[0]] * signs[wrong[1]]]), 600)
    assert [len(half.unique()) for half in (component[:300], component[300:])] == [1, 1] and component[0] != component[300]
    assert all(len((half * signs[at]).unique()) == 1 for half, at in ((found[:300], own[:300]), (found[300:], own[300:])))


def test_nearly_all_faces_of_a_thin_slab_look_outward() -> None:
    """Near both sides and the rim, planes through neighbours tell no normal; faces with a common edge do."""
    grid = torch.stack(torch.meshgrid(torch.arange(21), torch.arange(21), torch.arange(3), indexing="ij"), 3).reshape(-1, 3)
    top = torch.tensor([20, 20, 2])
    points = grid[((grid == 0) | (grid == top)).any(1)].double()
    a, b, c = points[nmt._clouds.cloud_faces(points)].unbind(1)
    is_outward = (torch.linalg.cross(b - a, c - a) * ((a + b + c) / 3 - top / 2)).sum(1) > 0
    assert len(a) > 1800 and float(is_outward.double().mean()) > 0.93


@pytest.mark.parametrize("sign", [None, 1, -1])
def test_faces_of_a_sphere_are_closed_and_look_along_the_normals(sign: int | None) -> None:
    points = sphere(2000, 5.0)
    normals = None if sign is None else sign * (points - 5)
    faces = nmt._clouds.cloud_faces(points, None, normals)
    # Two stars may disagree with the two others at an edge.
    sides = set(half_edges(faces))
    assert sum((b, a) in sides for a, b in sides) > 0.99 * len(sides) > 0.98 * 3 * len(faces)
    assert volume(points - 5, faces) == pytest.approx(4 / 3 * np.pi * (sign or 1), rel=0.02)


def test_chosen_faces_are_those_of_one_choice_after_the_other() -> None:
    random = np.random.default_rng(5)
    faces = torch.from_numpy(np.array([random.permutation(9)[:3] for _ in range(120)]))
    p = torch.from_numpy(random.random(120))
    expected: list[int] = []
    taken: set[tuple[int, int]] = set()
    order = p.argsort(descending=True).tolist()
    for at in order:
        sides = half_edges(faces[at : at + 1])
        if p[at] > 0.5 and not taken & set(sides):
            expected.append(at)
            taken |= set(sides)
    n_likely = len(expected)
    found = choose_manifold(faces, p, 9)
    assert set(expected) <= set(found.tolist()) and bool((p[found] > 0.5).sum() >= n_likely)
    sides = half_edges(faces[found])
    assert len(sides) == len(set(sides))
    for at in set(found.tolist()) - set(expected):
        others = set(sides) - set(half_edges(faces[at : at + 1]))
        assert sum((b, a) in others for a, b in half_edges(faces[at : at + 1])) > 1


def noisy(points: Any, noise: float, seed: int = 1) -> Any:
    return points + noise * torch.randn(points.shape, generator=torch.Generator().manual_seed(seed), dtype=points.dtype)


def off_sphere(points: Any) -> float:
    return float((points.detach().norm(dim=1) - 1).square().mean().sqrt())


def off_torus(points: Any) -> float:
    x, y, z = points.detach().unbind(1)
    return float((((x * x + y * y).sqrt() - 1).square() + z * z).sqrt().sub(0.3).square().mean().sqrt())


def even_torus(n: int) -> Any:
    """Returns points of a torus of radii 1 and 0.3, drawn by area."""
    random = np.random.default_rng(1)
    u, v = random.random((2, 4 * n)) * 2 * np.pi
    v = v[random.random(4 * n) < (1 + 0.3 * np.cos(v)) / 1.3][:n]
    u, r = u[:n], 1 + 0.3 * np.cos(v)
    return torch.from_numpy(np.stack([r * np.cos(u), r * np.sin(u), 0.3 * np.sin(v)], 1).astype(np.float32))


def test_noise_is_found_and_smoothed() -> None:
    points, rough, other = sphere(3000), noisy(sphere(3000), 0.05), noisy(even_torus(1500), 0.05)
    assert nmt.smooth_points(points) is points
    smooth = nmt.smooth_points(rough)
    assert off_sphere(smooth) < 0.3 * off_sphere(rough)
    packed = nmt.smooth_points(torch.cat([rough, points, other]), torch.arange(3).repeat_interleave(torch.tensor([3000, 3000, 1500])))
    assert torch.equal(packed[3000:6000], points)
    assert torch.allclose(packed, torch.cat([smooth, points, nmt.smooth_points(other)]), atol=1e-5)


def test_crowded_points_are_smoothed_as_others() -> None:
    """Ten times as many points on a cap have the noise of the others, which is several times their distance."""
    dense = sphere(60_000)
    rough = noisy(torch.cat([sphere(3000), dense[dense[:, 2] > 0.9]]), 0.05)
    smooth, crowding = _smoothing.smooth_noise(rough)
    assert off_sphere(smooth[3000:]) < 0.3 * off_sphere(rough[3000:])
    assert float(crowding[3000:].median()) > 2 * float(crowding[:3000].median()) >= 2


def test_points_of_a_quadric_stay_and_few_points_do_not_break() -> None:
    x, y = torch.meshgrid(torch.arange(20) / 20.0, torch.arange(20) / 20.0, indexing="ij")
    points = torch.stack([x, y, 0.1 * x * x + 0.2 * x * y], 2).reshape(-1, 3)
    assert float((nmt.smooth_points(points, neighbours=24) - points).abs().max()) < 2e-4
    line = torch.arange(9)[:, None] * torch.tensor([[1.0, 2.0, 0.5]])
    for few in (line, torch.zeros((5, 3)), points[:4], points[:1]):
        assert torch.allclose(nmt.smooth_points(few, neighbours=24), few, atol=1e-5)


def test_gradients_of_smoothing_are_exact() -> None:
    points = noisy(sphere(40).double(), 0.02)[:14].requires_grad_()
    assert torch.autograd.gradcheck(lambda x: nmt.smooth_points(x, neighbours=12), points)
    assert torch.autograd.gradgradcheck(lambda x: nmt.smooth_points(x, neighbours=12), points, fast_mode=True)
    # Two equal eigenvalues, at which decompositions have no derivative.
    ring = torch.tensor([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 0]], dtype=torch.float64).requires_grad_()
    nmt.smooth_points(ring, neighbours=4).square().sum().backward()
    assert ring.grad is not None and bool(ring.grad.isfinite().all())


def test_holes_are_closed_and_large_ones_stay() -> None:
    points = sphere(2000).double()
    faces = torch.from_numpy(np.asarray(nm.mesh_points(points.numpy()).faces).astype(np.int64))
    assert open_share(faces) == 0 and volume(points, faces) > 0
    scaled = nmt.in_edge_lengths(points, nmt.mesh_graph(faces, 2000))
    random = np.random.default_rng(2)
    kept = faces[torch.from_numpy(random.random(len(faces)) > 0.15)]
    closed, own = _closing.close_surface(kept, scaled, points)
    assert open_share(kept) > 0.1 and open_share(closed) == 0
    assert torch.equal(closed[own >= 0], kept[own[own >= 0]]) and int((own >= 0).sum()) > 0.9 * len(kept)
    assert volume(points, closed) == pytest.approx(volume(points, faces), rel=0.01)
    cap = faces[(points[faces].mean(1)[:, 2] < 0.8)]
    opened, own = _closing.close_surface(cap, scaled, points)
    assert torch.equal(opened, cap) and open_share(cap) > 0


def test_samples_are_placed_at_corners() -> None:
    """Regions at the corners of a cube have three planes; the sample near a corner goes there, with a gradient."""
    n = 8
    x, y = torch.meshgrid(torch.arange(n + 1.0), torch.arange(n + 1.0), indexing="ij")
    zero = torch.zeros_like(x)
    sides = [torch.stack(side, 2).reshape(-1, 3) for side in ([x, y, zero], [y, zero, x], [zero, x, y])]
    square = torch.from_numpy(nm_grid(n))
    points = torch.cat(sides).double().requires_grad_()
    faces = torch.cat([square + at * (n + 1) ** 2 for at in range(3)])
    samples, regions = torch.tensor([n + 2]), torch.zeros(len(points), dtype=torch.int64)
    quadrics = _placing.region_quadrics(points, faces, regions, samples)
    assert float(quadrics.steps[0].detach().add(points[n + 2].detach()).abs().max()) < 0.01
    placed = _placing.place_samples(quadrics, torch.empty((0, 3), dtype=torch.int64))
    placed.sum().backward()
    assert points.grad is not None and bool(points.grad.isfinite().all()) and float(points.grad.abs().max()) > 0.01


def nm_grid(n: int) -> Any:
    """Returns the faces of a square of n x n cells."""
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b, c, d = ((i + di) * (n + 1) + j + dj for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)


@pytest.mark.parametrize("ratio", [1.0, 0.3])
def test_a_cloud_becomes_a_surface(layer: Any, ratio: float) -> None:
    light = nm.simplify(MESHES / "spot.ply", ratio=1.0, weld=True)
    whole = volume(torch.from_numpy(np.asarray(light.vertices)), torch.from_numpy(np.asarray(light.faces, np.int64)))
    points = torch.from_numpy(np.asarray(light.vertices, np.float32))
    for keep_points in (True, False):
        result = layer(points, ratio=ratio, seed=1, keep_points=keep_points)
        assert torch.equal(result.vertices, points[result.samples]) == (keep_points or ratio == 1)
        assert len(result.samples) == int(ratio * len(points)) and len(result.probabilities) == len(result.faces)
        assert open_share(result.faces) == 0 and result.points is points
        assert volume(result.vertices, result.faces) == pytest.approx(whole, rel=0.05)
        assert result.pool.shape == (len(result.samples), len(points))
        is_candidate = result.chosen >= 0
        assert torch.equal(result.candidates.faces[result.chosen[is_candidate]], result.faces[is_candidate].sort(1).values)


@pytest.mark.parametrize("ratio", [1.0, 0.2])
def test_noisy_clouds_become_surfaces(layer: Any, ratio: float) -> None:
    for shape, error, inside in ((sphere(4000), off_sphere, 4 / 3 * np.pi), (even_torus(4000), off_torus, 2 * np.pi**2 * 0.09)):
        points = noisy(shape, 0.03).requires_grad_()
        result = layer(points, ratio=ratio, seed=1)
        assert open_share(result.faces) < 0.02
        assert volume(result.vertices, result.faces) == pytest.approx(inside, rel=0.05)
        used = result.vertices[result.faces.unique()]
        assert error(used) < 0.5 * error(points)
        used.square().sum().backward()
        assert points.grad is not None and bool(points.grad.isfinite().all()) and int((points.grad != 0).any(1).sum()) > 0.9 * len(points)


def test_losses_reach_all_stages(layer: Any) -> None:
    points = torch.from_numpy(torus(24, 16)[0]).requires_grad_()
    result = layer(points, ratio=0.4, seed=1)
    layer.zero_grad()
    losses.total(losses.objective_terms(result, points, result.surface)).backward()
    assert all(p.grad is not None and p.grad.isfinite().all() for p in layer.parameters())
    result = layer(points, ratio=0.4, seed=1)
    result.candidates.probabilities.sum().backward()
    assert bool(points.grad.isfinite().all()) and float(points.grad.abs().max()) > 0


def test_losses_judge_candidates_where_samples_were_before_they_were_placed(layer: Any) -> None:
    points = torch.from_numpy(torus(24, 16)[0])
    samples = torch.arange(0, len(points), 3)
    results = [layer(points, samples=samples, keep_points=keeps) for keeps in (True, False)]
    assert not torch.equal(results[0].vertices, results[1].vertices)
    terms = []
    for result in results:
        torch.manual_seed(0)
        terms.append(losses.objective_terms(result, points, result.surface))
    assert all(float(terms[0][name][1].detach()) == pytest.approx(float(terms[1][name][1].detach()), rel=1e-5) for name in ("forward", "coverage"))


def test_no_points_stay_none() -> None:
    assert nmt.smooth_points(torch.zeros(0, 3)).shape == (0, 3)


def test_packed_clouds_are_those_alone(layer: Any) -> None:
    clouds = [sphere(300), torch.from_numpy(torus(20, 16)[0]), sphere(20)]
    alone = [layer(points, ratio=0.5, seed=4 + at) for at, points in enumerate(clouds)]
    batch = torch.arange(3).repeat_interleave(torch.tensor([len(points) for points in clouds]))
    for packed in (layer(clouds, ratio=0.5, seed=4), layer(torch.cat(clouds), None, 0.5, batch, seed=4)):
        for one, (vertices, faces) in zip(alone, packed.unpack(), strict=True):
            assert torch.equal(one.vertices, vertices) and torch.equal(one.faces, faces)
    pair = layer(torch.stack([sphere(100), sphere(100, 2.0)]), ratio=0.5, seed=1)
    assert [len(vertices) for vertices, _ in pair.unpack()] == [50, 50]


@pytest.mark.parametrize("n", range(3, 11))
def test_tiny_clouds(layer: Any, n: int) -> None:
    random = torch.Generator().manual_seed(n)
    line = torch.arange(n)[:, None] * torch.tensor([[1.0, 2.0, 0.5]])
    for points in (torch.rand((n, 3), generator=random), line, torch.zeros((n, 3))):
        for n_samples in (1, 2, n):
            result = layer(points, n_samples=n_samples, seed=0)
            assert result.scores.isfinite().all() and len(result.samples) == n_samples
            assert points is not line or len(result.faces) == 0
    corners = torch.tensor([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert nmt._clouds.cloud_faces(corners).sort().values.tolist() == [[0, 1, 2]]


def test_errors(layer: Any) -> None:
    points = sphere(30)
    wrong = [
        (r"vertices: a cloud of 2 points: .*at least three", lambda: layer(points[:2], ratio=1.0)),
        (r"vertices: a cloud of 0 points", lambda: layer(points[:0], ratio=1.0)),
        (r"vertices: a cloud of 1 points", lambda: layer([points, points[:1]], ratio=1.0)),
        (r"vertices: give a list of at least one cloud", lambda: layer([], ratio=1.0)),
        (r"vertices: .*give n x 3", lambda: layer(points[:, :2], ratio=1.0)),
        (r"vertices: a number is not finite", lambda: layer(points / 0, ratio=1.0)),
        (r"batch: .*ascending", lambda: layer(points, None, 0.5, torch.arange(30).flip(0))),
        (r"normals: .*give 30 x 3", lambda: layer(points, ratio=0.5, normals=points[1:])),
        (r"normals: .*only clouds", lambda: layer(points, torch.tensor([[0, 1, 2]]), 0.5, normals=points)),
    ]  # fmt: skip
    for said, call in wrong:
        with pytest.raises(nm.NeuralMeshError, match=said):
            call()

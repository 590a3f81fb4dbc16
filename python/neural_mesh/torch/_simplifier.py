"""The paper's system as a layer: samples, edges and faces of a mesh or a batch of meshes, with gradients."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import torch

from .. import _native
from .._native import NeuralMeshError
from ._closing import close_surface
from ._clouds import cloud_faces, star_triangles
from ._graphs import candidate_faces, in_edge_lengths, is_among, mesh_graph, unite_triangles, vertex_normals
from ._network import EdgePredictor, Edges, FaceClassifier, PointSampler
from ._packed import Packed, pack_meshes
from ._placing import place_samples, region_quadrics, score_gains
from ._regions import Quotient, assign_to_samples, choose_faces, choose_manifold, orient_faces, pooling_matrices, quotient
from ._sampling import inclusion, log_probability, multinomial_samples, sample_counts, scattered_samples
from ._smoothing import smooth_noise

Draw = Literal["scattered", "multinomial"]
Gradient = Literal["straight-through", "none"]


@dataclass(frozen=True)
class Candidates:
    """The triangles that the Face Classifier judged, and what it judged them by."""

    points: Any
    """The samples in the network's unit, n_samples x 3."""
    graph: Any
    """G_ext, `[2, n_entries]`."""
    edges: Edges
    """S and A_s along G_ext."""
    faces: Any
    """Corners, ascending samples: n_candidates x 3."""
    entries: Any
    """Entries of G_ext of the edges ij, ik, jk: n_candidates x 3."""
    prior: Any
    """p_init, n_candidates."""
    probabilities: Any
    """p, n_candidates; in training with the gradient through the draw."""
    is_surface: Any
    """True where three regions of the mesh meet in a face, n_candidates."""
    neighbours: Any
    """G_tri, `[2, n_pairs]`."""
    between: Quotient
    """Edges and triangles between the regions."""


@dataclass(frozen=True)
class Simplified:
    """A simplified mesh, or a packed batch of them."""

    vertices: Any
    """Positions of the samples, n_samples x 3; of clouds, smoothed and placed. Differentiable by the input. Some may be on no face."""
    faces: Any
    """Faces over these vertices, n_faces x 3, wound like the input."""
    probabilities: Any
    """Probability of each face, n_faces; differentiable by the network. 1 for faces that close holes."""
    samples: Any
    """Vertices of the input that were sampled, ascending: n_samples."""
    batch: Any
    """Mesh of each sample, n_samples."""
    scores: Any
    """Score of each input vertex by which the samples were drawn, n."""
    counts: Any
    """Number of samples of each mesh, n_meshes."""
    mesh: Any
    """Mesh of each input vertex, n."""
    regions: Any
    """Sample (index into `samples`) whose region each input vertex is in, n; -1 in components without a sample."""
    candidates: Candidates
    """All candidate faces."""
    chosen: Any
    """The candidate that is each face, n_faces; -1 for faces that close holes of clouds."""
    surface: Any
    """Faces of the input, m x 3; of a cloud, the triangles on which its points agree."""
    points: Any
    """Positions of the input, n x 3; of a cloud, smoothed."""

    @cached_property
    def inclusion(self) -> Any:
        """Probability of each input vertex to be sampled, n; differentiable by the scores."""
        return inclusion(self.scores, self.counts, self.mesh)

    @property
    def log_probability(self) -> Any:
        """Logarithm of the probability of each mesh's samples, n_meshes: for a score-function gradient."""
        return log_probability(self.inclusion, self.samples, self.mesh, len(self.counts))

    @cached_property
    def _pooling(self) -> tuple[Any, Any]:
        return pooling_matrices(self.regions, len(self.samples), self.vertices.dtype)

    @property
    def pool(self) -> Any:
        """Sparse matrix n_samples x n: `pool @ features` averages over each region."""
        return self._pooling[0]

    @property
    def unpool(self) -> Any:
        """Sparse matrix n x n_samples: `unpool @ features` gives each vertex the value of its region."""
        return self._pooling[1]

    def unpack(self) -> list[tuple[Any, Any]]:
        """Returns vertices and faces of each mesh of the batch."""
        mesh = self.batch[self.faces[:, 0]]
        result, start = [], 0
        for number, count in enumerate(self.counts.tolist()):
            result.append((self.vertices[start : start + count], self.faces[mesh == number] - start))
            start += count
        return result


class Simplifier(torch.nn.Module):
    """The paper's network and assembly; `state_dict` has the tensor names of a weights file.

    point_sampler, edge_predictor, face_classifier: stages of any sizes; default sizes and random weights by default
    objective: name of the trained objective, written to weights files; only weights of "paper" work with `assembly="paper"`
    draw: "scattered" keeps samples apart (dart throwing), as the library does; "multinomial" draws independently, as the paper prints
    gradient: "straight-through" lets losses of faces reach the Point Sampler: the value of a face's probability stays, and its gradient
        is that of its product with the inclusion probabilities of its corners, relative to these; "none" detaches the draw
    """

    def __init__(
        self,
        point_sampler: PointSampler | None = None,
        edge_predictor: EdgePredictor | None = None,
        face_classifier: FaceClassifier | None = None,
        *,
        objective: str | None = "paper",
        draw: Draw = "scattered",
        gradient: Gradient = "straight-through",
    ) -> None:
        super().__init__()
        for name, value, known in (("draw", draw, ("scattered", "multinomial")), ("gradient", gradient, ("straight-through", "none"))):
            if value not in known:
                raise NeuralMeshError(f'{name}: "{value}": give "{known[0]}" or "{known[1]}"')
        self.point_sampler = PointSampler() if point_sampler is None else point_sampler
        self.edge_predictor = EdgePredictor() if edge_predictor is None else edge_predictor
        self.face_classifier = FaceClassifier() if face_classifier is None else face_classifier
        self.objective, self.draw, self.gradient = objective, draw, gradient

    @classmethod
    def from_weights(cls, name_or_file: str | os.PathLike[str] = "paper-open", **options: Any) -> Simplifier:
        """Reads weights: those shipped as "paper-open" or "default", or a safetensors file. Options are those of the class.

        In "default" only the Point Sampler is trained. Raises `NeuralMeshError` if a file cannot be read."""
        sizes, tensors, objective = _read_weights(name_or_file)
        of = dict(sizes)
        stages = [
            kind(**{argument: of[name] for argument, name in kind._SIZES.items()})  # type: ignore[arg-type]
            for kind in (PointSampler, EdgePredictor, FaceClassifier)
        ]
        simplifier = cls(*stages, objective=objective, **options)  # type: ignore[arg-type]
        simplifier.load_state_dict({name: torch.from_numpy(x) for name, x in tensors})
        return simplifier

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a weights file for `simplify(weights=...)`, the option `--weights` of the program, and `from_weights`.

        An existing file is replaced, and stays intact if writing fails. Raises `NeuralMeshError` if the file cannot be written."""
        stages = (self.point_sampler, self.edge_predictor, self.face_classifier)
        sizes = {name: size for stage in stages for name, size in stage.sizes.items()}
        tensors = [(name, x.detach().to("cpu", torch.float32).contiguous().numpy()) for name, x in self.state_dict().items()]
        _write_file(Path(path), _native.weights_bytes((sizes, tensors), self.objective))

    def extra_repr(self) -> str:
        return f"draw={self.draw}, gradient={self.gradient}"

    def forward(
        self,
        vertices: Any,
        faces: Any = None,
        ratio: float | None = None,
        batch: Any = None,
        *,
        n_samples: Any = None,
        samples: Any = None,
        scores: Any = None,
        seed: int | Any = None,
        normals: Any = None,
        keep_points: bool = False,
    ) -> Simplified:
        """Simplifies meshes to a share of their vertices, or clouds of points to surfaces over a share of them.

        vertices: n x 3, of the network's device; a list of such; or B x n x 3
        faces: n_faces x 3; a list of such; or one for B meshes; none for clouds
        ratio: share of the vertices that become samples, rounded down
        batch: mesh of each vertex, ascending, for several meshes packed into one
        n_samples: number of samples of each mesh instead of `ratio`
        samples: vertices to keep instead of a draw
        scores: score of each vertex, n, instead of the Point Sampler's; from `fine_tune_scores`, say
        seed: whole number, or one for each mesh; mesh i of a batch draws as alone with `seed + i`. From torch's generator by default
        normals: those towards which the faces of clouds look, n x 3 for all points; outward by default
        keep_points: leaves vertices at the points of clouds; otherwise noise is smoothed, and fewer vertices than points are placed
        """
        packed = pack_meshes(vertices, faces, batch)
        vertices, _, batch, n_meshes = packed
        is_cloud, crowding = packed.faces is None, None
        several = batch if n_meshes > 1 else None
        if normals is not None and not is_cloud:
            raise NeuralMeshError("normals: only clouds need them: leave out normals or faces")
        if is_cloud:
            vertices, crowding = (vertices, None) if keep_points else smooth_noise(vertices, several)
            packed = packed._replace(vertices=vertices, faces=cloud_faces(vertices, several, normals))
        surface = packed.faces
        if sum(given is not None for given in (ratio, n_samples, samples)) != 1:
            raise NeuralMeshError("give exactly one of ratio, n_samples and samples")
        if ratio is not None and not 0 < ratio <= 1:
            raise NeuralMeshError(f"ratio: {ratio}: give a share above 0, at most 1")
        graph = mesh_graph(surface, len(vertices))
        points = in_edge_lengths(vertices, graph, batch, n_meshes).to(self.face_classifier.output.bias.dtype)
        if scores is None:
            scores = self.point_sampler(points, graph, self._normals(packed))
            # Where points are denser than their noise, samples are no denser for it.
            scores = scores if crowding is None else scores - crowding.log().to(scores.dtype)
        else:
            scores = _check_scores(scores, points)
        if samples is None:
            counts, seeds = sample_counts(batch, n_meshes, ratio, n_samples), _seeds(seed, n_meshes, vertices.device)
            samples = self._draw_samples(points, graph, scores, counts, batch, seeds)
        else:
            samples, seeds = _check_samples(samples, len(vertices), vertices.device), None
            counts = torch.bincount(batch[samples], minlength=n_meshes)
        regions = assign_to_samples(points, graph, samples)
        is_part = counts < torch.bincount(batch)
        places = is_cloud and not keep_points and bool(is_part.any())
        if places and seeds is not None:
            # Placed vertices leave other errors than samples, which a second draw makes equal.
            with torch.no_grad():
                gains = score_gains(region_quadrics(vertices, surface, regions, samples), regions, batch[samples], n_meshes)
            scores = scores + torch.where(is_part[batch], gains, 0).to(scores.dtype)
            samples = self._draw_samples(points, graph, scores, counts, batch, seeds)
            regions = assign_to_samples(points, graph, samples)
        sample_batch = batch[samples]
        between = quotient(vertices, surface, graph, regions, len(samples))
        chances = None
        if self.gradient == "straight-through" and scores.requires_grad:
            chances = inclusion(scores, counts, batch)
        gates = None if chances is None else chances[samples]
        candidates = self._classify(points[samples], between, sample_batch, n_meshes, gates, is_cloud)
        positions = vertices[samples]
        chosen, faces = _assemble(candidates, positions, is_cloud)
        if places:
            placed = place_samples(region_quadrics(vertices, surface, regions, samples), faces).to(vertices.dtype)
            positions = torch.where(is_part[sample_batch, None], placed, positions)
        judged = torch.where(chosen >= 0, candidates.probabilities[chosen], 1)
        result = Simplified(
            positions, faces, judged, samples, sample_batch, scores, counts, batch, regions, candidates, chosen, surface, vertices
        )
        if chances is not None:
            result.__dict__["inclusion"] = chances
        return result

    def _normals(self, packed: Packed) -> Any:
        if self.point_sampler.sizes["point_sampler_inputs"] != 6:
            return None
        return vertex_normals(packed.vertices, packed.faces).to(self.face_classifier.output.bias.dtype)

    def _draw_samples(self, points: Any, graph: Any, scores: Any, counts: Any, batch: Any, seeds: Any) -> Any:
        if self.draw == "multinomial":
            return multinomial_samples(scores, counts, batch, seeds)
        return scattered_samples(points, graph, scores, counts, batch, seeds)

    def _classify(self, points: Any, between: Quotient, batch: Any, n_meshes: int, chances: Any, is_cloud: bool) -> Candidates:
        """Predicts edges between the samples, and judges the candidate faces."""
        points = in_edge_lengths(points, between.edges, batch, n_meshes)
        several = batch if n_meshes > 1 else None
        graph, product = self.edge_predictor.extend(points, between.edges, several)
        edges = self.edge_predictor(points, graph, product)
        per_point = self.face_classifier.sizes["face_candidates"]
        certain = between.triangles
        if is_cloud:
            certain = unite_triangles(certain, star_triangles(points, several)[0], len(points))
        faces, entries = candidate_faces(graph, edges.adjacency, certain, per_point, several, len(points))
        prior = edges.adjacency[entries].mean(1)
        neighbours = self.face_classifier.join(points, faces, several)
        probabilities = self.face_classifier(points, faces, prior, neighbours)
        if chances is not None:
            # Where a corner is certain to be a sample, nothing depends on its score.
            gates = chances / chances.detach().clamp(min=1e-12)
            probabilities = probabilities * gates[faces].prod(1)
        is_surface = is_among(faces, between.triangles, len(points))
        return Candidates(points, graph, edges, faces, entries, prior, probabilities, is_surface, neighbours, between)


def _assemble(candidates: Candidates, positions: Any, is_cloud: bool) -> tuple[Any, Any]:
    """Returns the candidate that is each face, -1 for none, and the wound faces."""
    probabilities, between = candidates.probabilities, candidates.between
    if not is_cloud:
        chosen = choose_faces(candidates.entries, probabilities, candidates.graph.shape[1])
        return chosen, orient_faces(candidates.faces[chosen], positions, between)
    wound = orient_faces(candidates.faces, positions, between)
    chosen = choose_manifold(wound, probabilities, len(positions))
    faces, own = close_surface(wound[chosen], candidates.points, between.normals)
    return torch.where(own >= 0, chosen[own], -1), faces


def _seeds(seed: Any, n_meshes: int, device: Any) -> Any:
    if seed is None:
        seed = torch.randint(0, 1 << 31, ())
    seed = torch.as_tensor(seed).to(device)
    return seed if seed.dim() == 1 else seed + torch.arange(n_meshes, device=device)


def _check_scores(scores: Any, points: Any) -> Any:
    scores = torch.as_tensor(scores, device=points.device).to(points.dtype)
    if scores.shape != points.shape[:1] or not bool(scores.isfinite().all()):
        raise NeuralMeshError(f"scores: give a finite number for each of the {len(points)} vertices")
    return scores


def _check_samples(samples: Any, n: int, device: Any) -> Any:
    samples = torch.unique(torch.as_tensor(samples, device=device).long())
    if len(samples) == 0 or int(samples[0]) < 0 or int(samples[-1]) >= n:
        raise NeuralMeshError(f"samples: give vertices from 0 to {n - 1}, at least one")
    return samples


def _read_weights(name_or_file: str | os.PathLike[str]) -> Any:
    if name_or_file in ("paper-open", "default"):
        return _native.shipped_weights(str(name_or_file))
    try:
        return _native.read_weights(Path(name_or_file).read_bytes())
    except OSError as error:
        raise NeuralMeshError(f'{os.fspath(name_or_file)}: {error.strerror}: give a weights file, "paper-open" or "default"') from None
    except NeuralMeshError as error:
        raise NeuralMeshError(f"{os.fspath(name_or_file)}: {error}") from None


def _write_file(path: Path, data: bytes) -> None:
    temporary = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise NeuralMeshError(f"{path}: {error.strerror}") from None

"""The network's stages (docs/paper.md, Secs. 3.1 to 3.3) as PyTorch modules.

Forward and backward run in the library: on the CPU, in single precision, on `torch.get_num_threads()` threads. Results have the type
and device of the points. Parameters have the names of a weights file, n_in x n_out each. Gradients reach parameters, points, normals
and priors, but not graphs. Second derivatives are not available.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeVar

import torch

from . import _native
from ._native import NeuralMeshError
from ._torch_arrays import as_numpy
from ._torch_graphs import edge_rows, extended_graph, face_rows, point_rows, triangle_graph

_S = TypeVar("_S", bound="_Stage")

# Sizes by name, tensors by name, and the trained objective, if known.
_Weights = tuple[list[tuple[str, int]], list[tuple[str, Any]], "str | None"]


class Edges(NamedTuple):
    """Output of the Edge Predictor: G_ext with attention and adjacency."""

    graph: Any
    """Entries (i, j) of G_ext, both directions, sorted by row, then column: n_entries x 2, int64."""
    attention: Any
    """S, Eq. (2), one value per entry, n_entries; each row i sums to 1."""
    adjacency: Any
    """A_s, Eq. (3), one value per entry, n_entries; at least 0 and symmetric."""


class _Stage(torch.nn.Module):
    _NAME: ClassVar[str]
    # Names of the arguments in a weights file.
    _SIZES: ClassVar[Mapping[str, str]]

    def __init__(self, seed: int = 0, **sizes: int) -> None:
        super().__init__()
        self.sizes = {name: sizes[argument] for argument, name in self._SIZES.items()}
        """Sizes of the stage, by their names in a weights file."""
        self._names: list[str] = []
        for name, array in self._stage_tensors(_native.random_weights(self.sizes, seed)):
            self._names.append(name)
            _register(self, name, torch.from_numpy(array))

    @classmethod
    def shipped(cls: type[_S], name: str = "default") -> _S:
        """Returns the stage with shipped weights: "default" for `simplify`, or "paper-open" for `assembly="paper"` and `mesh_points`.

        In "default" only the Point Sampler is trained."""
        return cls._from_weights(_native.shipped_weights(name))

    @classmethod
    def from_file(cls: type[_S], path: str | os.PathLike[str]) -> _S:
        """Reads the stage from a weights file (safetensors); raises `NeuralMeshError` if it cannot be read."""
        return cls._from_weights(_read_weights(path))

    @classmethod
    def _from_weights(cls: type[_S], weights: _Weights) -> _S:
        sizes = dict(weights[0])
        stage = cls(**{argument: sizes[name] for argument, name in cls._SIZES.items()})
        stage.load_state_dict({name: torch.from_numpy(array) for name, array in cls._stage_tensors(weights)})
        return stage

    @classmethod
    def _stage_tensors(cls, weights: _Weights) -> list[tuple[str, Any]]:
        """Returns the tensors of this stage, by their names within it."""
        prefix = cls._NAME + "."
        return [(name[len(prefix) :], array) for name, array in weights[1] if name.startswith(prefix)]

    def tensors(self) -> dict[str, Any]:
        """Returns the parameters by their names in a weights file."""
        return {f"{self._NAME}.{name}": attrgetter(name)(self) for name in self._names}

    def extra_repr(self) -> str:
        return ", ".join(f"{argument}={self.sizes[name]}" for argument, name in self._SIZES.items())

    def _run(self, start: Callable[..., Any], *inputs: Any) -> Any:
        """Returns the outputs of `start(stage, *inputs)`, differentiable by parameters and inputs."""
        tensors = self.tensors()

        def run_forward(*arrays: Any) -> Any:
            named = list(zip(tensors, arrays, strict=False))
            return start((self.sizes, named), *arrays[len(named) :])

        return _run_pass(run_forward, inputs[0], *tensors.values(), *inputs)


class PointSampler(_Stage):
    """The Point Sampler, Sec. 3.1: scores every vertex by DevConv layers, Eq. (1), along the edges of the mesh.

    inputs: 3 for positions, as in the paper, or 6 for positions and normals
    layers: number of DevConv layers
    width: channels of each layer
    hidden: channels of a layer before the score; 0 for none, as in the paper
    seed: seed of the initial weights
    """

    _NAME = "point_sampler"
    _SIZES: ClassVar[Mapping[str, str]] = {name: f"point_sampler_{name}" for name in ("inputs", "layers", "width", "hidden")}

    def __init__(self, inputs: int = 3, layers: int = 3, width: int = 32, hidden: int = 0, *, seed: int = 0) -> None:
        super().__init__(seed, inputs=inputs, layers=layers, width=width, hidden=hidden)

    def forward(self, points: Any, edges: Any, normals: Any = None) -> Any:
        """Returns a score for each vertex, n; their softmax is the multinomial distribution of Sec. 3.1.

        points: n x 3, in edge lengths (`in_edge_lengths`)
        edges: n_edges x 2, vertex indices, each edge in one or both directions (`edges_of_faces`)
        normals: n x 3, unit vectors (`vertex_normals`), zero by default; used only with `inputs=6`
        """
        rows, threads = edge_rows(edges), torch.get_num_threads()

        def start(stage: Any, points: Any, normals: Any = None) -> Any:
            return _native.point_sampler(stage, points, rows, normals, threads)

        inputs = [point_rows(points, "points")] + ([] if normals is None else [point_rows(normals, "normals")])
        (scores,) = self._run(start, *inputs)
        return scores


class EdgePredictor(_Stage):
    """The Edge Predictor, Sec. 3.2: predicts edges between samples by DevConv, Eq. (1), and attention, Eq. (2), along G_ext.

    width: channels of the DevConv
    attention_width: channels of queries and keys
    knn: nearest samples that each sample is joined with
    seed: seed of the initial weights
    """

    _NAME = "edge_predictor"
    _SIZES: ClassVar[Mapping[str, str]] = {"width": "edge_predictor_width", "attention_width": "attention_width", "knn": "edge_knn"}

    def __init__(self, width: int = 32, attention_width: int = 32, knn: int = 15, *, seed: int = 0) -> None:
        super().__init__(seed, width=width, attention_width=attention_width, knn=knn)

    def forward(self, points: Any, edges: Any, graph: Any = None) -> Edges:
        """Returns the entries of G_ext with their attention and adjacency.

        points: n x 3, the samples, in lengths of `edges` (`in_edge_lengths`)
        edges: n_edges x 2, A of Eq. (3): samples joined by the mesh; each edge in one or both directions
        graph: n_entries x 2, entries of G_ext as in `Edges.graph`; `extended_graph` of points and edges by default
        """
        rows, threads = edge_rows(edges), torch.get_num_threads()
        points = point_rows(points, "points")
        graph = extended_graph(points, edges, self.sizes["edge_knn"]) if graph is None else graph
        entries = edge_rows(graph, "graph")

        def start(stage: Any, points: Any) -> Any:
            return _native.edge_predictor(stage, points, rows, entries, threads)

        return Edges(graph, *self._run(start, points))


class FaceClassifier(_Stage):
    """The Face Classifier, Sec. 3.3: predicts by TriConv layers, Eqs. (4) and (5), whether candidate faces belong to the surface.

    layers: number of TriConv layers
    width: channels of each layer
    knn: nearest triangles that each triangle is joined with; 0 joins those that share an edge
    candidates: candidate faces per sample, those with the largest prior; 0 for all
    seed: seed of the initial weights
    """

    _NAME = "face_classifier"
    _SIZES: ClassVar[Mapping[str, str]] = {
        "layers": "face_classifier_layers",
        "width": "face_classifier_width",
        "knn": "face_knn",
        "candidates": "face_candidates",
    }

    def __init__(self, layers: int = 3, width: int = 32, knn: int = 0, *, candidates: int = 6, seed: int = 0) -> None:
        super().__init__(seed, layers=layers, width=width, knn=knn, candidates=candidates)

    def forward(self, points: Any, faces: Any, prior: Any, graph: Any = None) -> Any:
        """Returns the probability of each candidate face, n_faces, from 0 to 1.

        points: n x 3, the samples, as for the Edge Predictor
        faces: n_faces x 3, candidates with ascending corners (`candidate_faces`)
        prior: n_faces, p_init of Sec. 3.2: `adjacency[candidates.entries].mean(1)`
        graph: n_entries x 2, (face, neighbour), sorted by row, then column; `triangle_graph` of points and faces by default
        """
        points, rows, threads = point_rows(points, "points"), face_rows(faces), torch.get_num_threads()
        if prior.dim() != 1 or not prior.is_floating_point():
            raise NeuralMeshError(f"prior: a tensor of shape {tuple(prior.shape)}, {prior.dtype}: give a number for each face")
        graph = triangle_graph(points, faces, self.sizes["face_knn"]) if graph is None else graph
        entries = edge_rows(graph, "graph")

        def start(stage: Any, points: Any, prior: Any) -> Any:
            return _native.face_classifier(stage, points, prior, rows, entries, threads)

        (probabilities,) = self._run(start, points, prior)
        return probabilities


class Network(torch.nn.Module):
    """The three stages of a weights file; `state_dict` has the file's tensor names.

    Stages of any sizes combine. A stage that is not given has default sizes and random weights."""

    objective: str | None
    """Objective of the training, or `None` if unknown. Weights for "paper" work only with `assembly="paper"`, others only without.
    Set it after training your own weights."""

    def __init__(
        self,
        point_sampler: PointSampler | None = None,
        edge_predictor: EdgePredictor | None = None,
        face_classifier: FaceClassifier | None = None,
        objective: str | None = None,
    ) -> None:
        super().__init__()
        self.point_sampler = PointSampler() if point_sampler is None else point_sampler
        self.edge_predictor = EdgePredictor() if edge_predictor is None else edge_predictor
        self.face_classifier = FaceClassifier() if face_classifier is None else face_classifier
        self.objective = objective

    @classmethod
    def shipped(cls, name: str = "default") -> Network:
        """Returns the network with shipped weights: "default" or "paper-open"."""
        return cls._from_weights(_native.shipped_weights(name))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Network:
        """Reads the network from a weights file (safetensors); raises `NeuralMeshError` if it cannot be read."""
        return cls._from_weights(_read_weights(path))

    @classmethod
    def _from_weights(cls, weights: _Weights) -> Network:
        return cls(PointSampler._from_weights(weights), EdgePredictor._from_weights(weights), FaceClassifier._from_weights(weights), weights[2])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a weights file for `simplify(weights=...)`, the option `--weights` of the program, and `from_file`.

        An existing file is replaced, and stays intact if writing fails. Raises `NeuralMeshError` if the file cannot be written."""
        stages = (self.point_sampler, self.edge_predictor, self.face_classifier)
        sizes = {name: size for stage in stages for name, size in stage.sizes.items()}
        tensors = [(name, as_numpy(tensor, torch.float32)) for stage in stages for name, tensor in stage.tensors().items()]
        _write_file(Path(path), _native.weights_bytes((sizes, tensors), self.objective))


def _register(module: Any, name: str, values: Any) -> None:
    """Registers values as a parameter; dots in the name become nested modules."""
    *path, last = name.split(".")
    for part in path:
        if part not in module._modules:
            module.add_module(part, torch.nn.Module())
        module = module._modules[part]
    module.register_parameter(last, torch.nn.Parameter(values))


def _read_weights(path: str | os.PathLike[str]) -> _Weights:
    try:
        return _native.read_weights(Path(path).read_bytes())
    except OSError as error:
        raise NeuralMeshError(f"{os.fspath(path)}: {error.strerror}") from None
    except NeuralMeshError as error:
        raise NeuralMeshError(f"{os.fspath(path)}: {error}") from None


def _write_file(path: Path, data: bytes) -> None:
    temporary = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise NeuralMeshError(f"{path}: {error.strerror}") from None


# `torch.compile` cannot trace the compiled module, so the graph breaks here.
@torch.compiler.disable
def _run_pass(run_forward: Callable[..., Any], like: Any, *tensors: Any) -> Any:
    return _Pass.apply(run_forward, like.dtype, like.device, *tensors)


class _Pass(torch.autograd.Function):
    """The autograd function of a stage; the compiled module keeps the state for backward."""

    @staticmethod
    def forward(ctx: Any, run_forward: Callable[..., Any], dtype: Any, device: Any, *tensors: Any) -> Any:
        ctx.native = run_forward(*(as_numpy(tensor, torch.float32) for tensor in tensors))
        ctx.likes = [(tensor.shape, tensor.dtype, tensor.device) for tensor in tensors]
        return tuple(torch.from_numpy(output).to(device, dtype) for output in ctx.native.outputs())

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *gradients: Any) -> Any:
        inputs = [as_numpy(gradient, torch.float32) for gradient in gradients]
        results = ctx.native.backward(inputs, torch.get_num_threads())
        of_tensors = zip(results, ctx.likes, strict=True)
        return None, None, None, *(torch.from_numpy(g).reshape(shape).to(device, dtype) for g, (shape, dtype, device) in of_tensors)

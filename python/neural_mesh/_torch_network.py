"""The stages of the network (docs/paper.md, Secs. 3.1 to 3.3) as modules of PyTorch, over the library's own functions.

Forward and backward run in the library, on the processor, in single precision, on as many threads as torch has
(`torch.set_num_threads`); results have the type and the device of the points. Parameters are those of a file of weights, by its
names: n_in x n_out each, rows times weights. Gradients reach parameters, points, normals and priors; graphs are chosen, not
computed smoothly, and are constants. Second derivatives are not there.
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

# Sizes by name, tensors by name, and the objective that was learned, if known.
_Weights = tuple[list[tuple[str, int]], list[tuple[str, Any]], "str | None"]


class Edges(NamedTuple):
    """What the Edge Predictor says of G_ext."""

    graph: Any
    """The entries (i, j) of G_ext, both directions, row by row, columns ascending: n_entries x 2, int64."""
    attention: Any
    """S, Eq. (2), one value for each entry: every row i is a distribution. n_entries."""
    adjacency: Any
    """A_s, Eq. (3), one value for each entry: not negative, symmetric. n_entries."""


class _Stage(torch.nn.Module):
    _NAME: ClassVar[str]
    # What arguments are called in a file of weights.
    _SIZES: ClassVar[Mapping[str, str]]

    def __init__(self, seed: int = 0, **sizes: int) -> None:
        super().__init__()
        self.sizes = {name: sizes[argument] for argument, name in self._SIZES.items()}
        """The sizes of the stage, by their names in a file of weights."""
        self._names: list[str] = []
        for name, array in self._own(_native.random_weights(self.sizes, seed)):
            self._names.append(name)
            _register(self, name, torch.from_numpy(array))

    @classmethod
    def shipped(cls: type[_S], name: str = "default") -> _S:
        """The stage with weights that ship: "default" steers `simplify`; "paper-open" is the paper's network, and serves
        `assembly="paper"` and `mesh_points`. Of "default" the Point Sampler alone has learned something."""
        return cls._of(_native.shipped_weights(name))

    @classmethod
    def from_file(cls: type[_S], path: str | os.PathLike[str]) -> _S:
        """The stage of a file of weights (safetensors)."""
        return cls._of(_read(path))

    @classmethod
    def _of(cls: type[_S], weights: _Weights) -> _S:
        sizes = dict(weights[0])
        stage = cls(**{argument: sizes[name] for argument, name in cls._SIZES.items()})
        stage.load_state_dict({name: torch.from_numpy(array) for name, array in cls._own(weights)})
        return stage

    @classmethod
    def _own(cls, weights: _Weights) -> list[tuple[str, Any]]:
        """The tensors of this stage, by their names in it."""
        prefix = cls._NAME + "."
        return [(name[len(prefix) :], array) for name, array in weights[1] if name.startswith(prefix)]

    def tensors(self) -> dict[str, Any]:
        """The parameters by their names in a file of weights."""
        return {f"{self._NAME}.{name}": attrgetter(name)(self) for name in self._names}

    def extra_repr(self) -> str:
        return ", ".join(f"{argument}={self.sizes[name]}" for argument, name in self._SIZES.items())

    def _run(self, start: Callable[..., Any], *inputs: Any) -> Any:
        """The outputs of `start(stage, *inputs)`; gradients reach parameters and inputs."""
        tensors = self.tensors()

        def started(*arrays: Any) -> Any:
            named = list(zip(tensors, arrays, strict=False))
            return start((self.sizes, named), *arrays[len(named) :])

        return _pass(started, inputs[0], *tensors.values(), *inputs)


class PointSampler(_Stage):
    """The Point Sampler, Sec. 3.1: a score for every vertex, from DevConv layers, Eq. (1), along the edges of the mesh.

    `inputs`: 3, positions, as in the paper, or 6, normals as well. `layers` of DevConv, each `width` wide. `hidden`: the width of
    a layer before the score, 0 for none, as in the paper. Weights are drawn from `seed`.
    """

    _NAME = "point_sampler"
    _SIZES: ClassVar[Mapping[str, str]] = {name: f"point_sampler_{name}" for name in ("inputs", "layers", "width", "hidden")}

    def __init__(self, inputs: int = 3, layers: int = 3, width: int = 32, hidden: int = 0, *, seed: int = 0) -> None:
        super().__init__(seed, inputs=inputs, layers=layers, width=width, hidden=hidden)

    def forward(self, points: Any, edges: Any, normals: Any = None) -> Any:
        """Scores of vertices, n; larger ones are sampled sooner, and only differences count. Their softmax is the multinomial
        distribution of Sec. 3.1.

        points: n x 3, in edge lengths (`in_edge_lengths`)
        edges: n_edges x 2, indices of vertices, each edge in one direction or in both (`edges_of_faces`)
        normals: n x 3, unit vectors (`vertex_normals`); looked at with `inputs=6` alone, and zero where not given
        """
        rows, threads = edge_rows(edges), torch.get_num_threads()

        def start(stage: Any, points: Any, normals: Any = None) -> Any:
            return _native.point_sampler(stage, points, rows, normals, threads)

        given = [point_rows(points, "points")] + ([] if normals is None else [point_rows(normals, "normals")])
        (scores,) = self._run(start, *given)
        return scores


class EdgePredictor(_Stage):
    """The Edge Predictor, Sec. 3.2: a DevConv, Eq. (1), and attention, Eq. (2), along G_ext, and the adjacency of Eq. (3).

    `width` of the DevConv, `attention_width` of queries and keys; `knn` nearest samples are joined with each. Weights are drawn
    from `seed`.
    """

    _NAME = "edge_predictor"
    _SIZES: ClassVar[Mapping[str, str]] = {"width": "edge_predictor_width", "attention_width": "attention_width", "knn": "edge_knn"}

    def __init__(self, width: int = 32, attention_width: int = 32, knn: int = 15, *, seed: int = 0) -> None:
        super().__init__(seed, width=width, attention_width=attention_width, knn=knn)

    def forward(self, points: Any, edges: Any, graph: Any = None) -> Edges:
        """The entries of G_ext, their attention and their adjacency.

        points: n x 3, the samples, in lengths of `edges` (`in_edge_lengths`)
        edges: n_edges x 2, A of Eq. (3): which samples the mesh joins; each edge in one direction or in both
        graph: n_entries x 2, the entries of G_ext as `Edges.graph` has them; `extended_graph` of these where not given
        """
        rows, threads = edge_rows(edges), torch.get_num_threads()
        points = point_rows(points, "points")
        graph = extended_graph(points, edges, self.sizes["edge_knn"]) if graph is None else graph
        entries = edge_rows(graph, "graph")

        def start(stage: Any, points: Any) -> Any:
            return _native.edge_predictor(stage, points, rows, entries, threads)

        return Edges(graph, *self._run(start, points))


class FaceClassifier(_Stage):
    """The Face Classifier, Sec. 3.3: the probability that a candidate face belongs to the surface, from TriConv layers, Eqs. (4)
    and (5), along the graph of nearest triangles.

    `layers` of TriConv, each `width` wide; `knn` triangles are joined with each, or those that share an edge with it where `knn` is 0.
    `candidates` for each sample are classified, those with the largest prior; all where it is 0. Weights are drawn from `seed`.
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
        """Probabilities of faces, n_faces, each in 0..1.

        points: n x 3, the samples, as the Edge Predictor has them
        faces: n_faces x 3, candidates; corners ascending (`candidate_faces`)
        prior: n_faces, p_init of Sec. 3.2: `adjacency[candidates.entries].mean(1)`
        graph: n_entries x 2, (face, neighbour), row by row, columns ascending; `triangle_graph` of these where not given
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
    """The three stages, as a file of weights holds them: names in `state_dict` are those of its tensors. Stages of any sizes go
    together; those that are not given have the default sizes and have learned nothing."""

    objective: str | None
    """What the weights learned, where the file says so: "paper" is refused for the closed assembly, what else there is for
    `assembly="paper"`. Set it to what you teach, or to `None`."""

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
        """The network with weights that ship, "default" or "paper-open"."""
        return cls._of(_native.shipped_weights(name))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Network:
        """The network of a file of weights (safetensors)."""
        return cls._of(_read(path))

    @classmethod
    def _of(cls, weights: _Weights) -> Network:
        return cls(PointSampler._of(weights), EdgePredictor._of(weights), FaceClassifier._of(weights), weights[2])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file of weights, for `weights=` of `simplify`, `--weights` of the program and `from_file`; whole or not at all.
        What is there is replaced."""
        stages = (self.point_sampler, self.edge_predictor, self.face_classifier)
        sizes = {name: size for stage in stages for name, size in stage.sizes.items()}
        tensors = [(name, as_numpy(tensor, torch.float32)) for stage in stages for name, tensor in stage.tensors().items()]
        _write(Path(path), _native.weights_bytes((sizes, tensors), self.objective))


def _register(module: Any, name: str, values: Any) -> None:
    """Makes values a parameter; of a name with dots of modules within."""
    *path, last = name.split(".")
    for part in path:
        if part not in module._modules:
            module.add_module(part, torch.nn.Module())
        module = module._modules[part]
    module.register_parameter(last, torch.nn.Parameter(values))


def _read(path: str | os.PathLike[str]) -> _Weights:
    try:
        return _native.read_weights(Path(path).read_bytes())
    except OSError as error:
        raise NeuralMeshError(f"{os.fspath(path)}: {error.strerror}") from None
    except NeuralMeshError as error:
        raise NeuralMeshError(f"{os.fspath(path)}: {error}") from None


def _write(path: Path, data: bytes) -> None:
    beside = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        beside.write_bytes(data)
        os.replace(beside, path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise NeuralMeshError(f"{path}: {error.strerror}") from None


# A compiler cannot look into the library: its graph breaks here.
@torch.compiler.disable
def _pass(started: Callable[..., Any], like: Any, *tensors: Any) -> Any:
    return _Pass.apply(started, like.dtype, like.device, *tensors)


class _Pass(torch.autograd.Function):
    """A stage forward and, by what it remembers, backward."""

    @staticmethod
    def forward(ctx: Any, started: Callable[..., Any], dtype: Any, device: Any, *tensors: Any) -> Any:
        ctx.native = started(*(as_numpy(tensor, torch.float32) for tensor in tensors))
        ctx.likes = [(tensor.shape, tensor.dtype, tensor.device) for tensor in tensors]
        return tuple(torch.from_numpy(output).to(device, dtype) for output in ctx.native.outputs())

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *gradients: Any) -> Any:
        given = [as_numpy(gradient, torch.float32) for gradient in gradients]
        results = ctx.native.backward(given, torch.get_num_threads())
        of_tensors = zip(results, ctx.likes, strict=True)
        return None, None, None, *(torch.from_numpy(g).reshape(shape).to(device, dtype) for g, (shape, dtype, device) in of_tensors)

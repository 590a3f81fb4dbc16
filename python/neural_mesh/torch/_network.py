"""The network's stages (docs/paper.md, Secs. 3.1 to 3.3) as PyTorch modules of PyTorch's operators, on any device.

Parameters have the names of a weights file, n_in x n_out each.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import torch

from .. import _native
from ._graphs import Product, extended_graph, product_terms, triangle_graph
from ._segments import neighbour_least, parts, softmax_by


def full_product(x: Any, weights: Any) -> Any:
    """Multiplies in the precision of the weights also under autocast: differences of the result would keep few of a lower one's digits."""
    with torch.autocast(x.device.type, enabled=False):
        return x.to(weights.dtype) @ weights


class DevConv(torch.nn.Module):
    """DevConv, Eq. (1): `f_i = ReLU(W_phi max_j W_theta (x_i - x_j))`; zero without neighbours."""

    def __init__(self, n_in: int, width: int) -> None:
        super().__init__()
        self.theta = torch.nn.Parameter(torch.zeros(n_in, width))
        self.phi = torch.nn.Parameter(torch.zeros(width, width))

    def forward(self, x: Any, graph: Any) -> Any:
        """Returns n x width features; `x` is n x n_in, `graph` `[2, n_entries]`."""
        # W is linear, so that the largest difference is the node's value less its neighbours' least.
        mapped = full_product(x, self.theta)
        return ((mapped - neighbour_least(mapped, graph)) @ self.phi).relu()


class Affine(torch.nn.Module):
    """A linear map with a bias."""

    def __init__(self, n_in: int, n_out: int) -> None:
        super().__init__()
        self.weights = torch.nn.Parameter(torch.zeros(n_in, n_out))
        self.bias = torch.nn.Parameter(torch.zeros(1, n_out))

    def forward(self, x: Any) -> Any:
        return x @ self.weights + self.bias


class SparseAttention(torch.nn.Module):
    """Attention along a graph, Eq. (2): `S[i, j] = softmax_j(-|q_i - k_j|^2 / 2)`."""

    def __init__(self, n_in: int, width: int) -> None:
        super().__init__()
        self.query = torch.nn.Parameter(torch.zeros(n_in, width))
        self.key = torch.nn.Parameter(torch.zeros(n_in, width))

    def forward(self, x: Any, graph: Any) -> Any:
        """Returns a number for each entry of the graph; those of a row sum to 1."""
        rows, cols = graph
        queries, keys = x @ self.query, x @ self.key
        closeness = [
            -0.5 * (queries.index_select(0, rows[part]) - keys.index_select(0, cols[part])).square().sum(1, dtype=self.query.dtype)
            for part in parts(rows.shape[0], queries.shape[1], x.device)
        ]
        return softmax_by(torch.cat(closeness), rows, x.shape[0])


class TriConv(torch.nn.Module):
    """TriConv, Eqs. (4) and (5): `f_n = sum_k MLP([r_{n,k} | f_n - f_k])`, a hidden layer with ReLU in the MLP."""

    def __init__(self, n_in: int, width: int) -> None:
        super().__init__()
        self.hidden = Affine(9 + n_in, width)
        self.output = Affine(width, width)

    def forward(self, positions: Any, x: Any, graph: Any) -> Any:
        """Returns n x width features; `positions` is n x 9, `x` n x n_in."""
        rows, cols = graph
        # The maps are linear: the first is applied before the difference of two faces, the last after the sum over them.
        mapped = full_product(torch.cat([positions, x], 1), self.hidden.weights)
        own = mapped + self.hidden.bias
        # Sums are in the parameters' precision also where products are in a lower one.
        sums = torch.zeros_like(mapped, dtype=self.output.bias.dtype)
        for part in parts(rows.shape[0], mapped.shape[1], x.device):
            pairs = (own.index_select(0, rows[part]) - mapped.index_select(0, cols[part])).relu()
            sums = sums.index_add(0, rows[part], pairs) if torch.is_grad_enabled() else sums.index_add_(0, rows[part], pairs)
        counts = torch.zeros_like(sums[:, :1]).index_add(0, rows, torch.ones_like(rows, dtype=sums.dtype)[:, None])
        return sums @ self.output.weights + counts * self.output.bias


def triangle_positions(points: Any, faces: Any) -> Any:
    """Computes `[t_min | t_max | b]` of each face, Eq. (4): n_faces x 9; corners ascend."""
    i, j, k = (points[faces[:, corner]] for corner in range(3))
    a, b, c = i - j, i - k, j - k
    return torch.cat([torch.minimum(torch.minimum(a, b), c), torch.maximum(torch.maximum(a, b), c), (i + j + k) / 3], 1)


class Edges(NamedTuple):
    """Output of the Edge Predictor, one value per entry of G_ext."""

    attention: Any
    """S, Eq. (2), n_entries; each row sums to 1."""
    adjacency: Any
    """A_s, Eq. (3), n_entries; at least 0 and symmetric."""


class _Stage(torch.nn.Module):
    _NAME: ClassVar[str]
    # Names of the arguments in a weights file.
    _SIZES: ClassVar[Mapping[str, str]]

    def _draw_weights(self, seed: int, **sizes: int) -> dict[str, Any]:
        """Stores the sizes, and draws initial weights as the library does; raises `NeuralMeshError` for a size out of range."""
        self.sizes = {name: sizes[argument] for argument, name in self._SIZES.items()}
        """Sizes of the stage, by their names in a weights file."""
        prefix = self._NAME + "."
        drawn = _native.random_weights(self.sizes, seed)[1]
        return {name[len(prefix) :]: torch.from_numpy(x) for name, x in drawn if name.startswith(prefix)}

    def extra_repr(self) -> str:
        return ", ".join(f"{argument}={self.sizes[name]}" for argument, name in self._SIZES.items())


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
        super().__init__()
        drawn = self._draw_weights(seed, inputs=inputs, layers=layers, width=width, hidden=hidden)
        for layer in range(layers):
            self.add_module(f"dev_conv_{layer}", DevConv(width if layer else inputs, width))
        self.hidden = Affine(width, hidden) if hidden else None
        self.score = Affine(hidden or width, 1)
        self.load_state_dict(drawn)

    def forward(self, points: Any, graph: Any, normals: Any = None) -> Any:
        """Returns a score for each vertex, n; their softmax is the multinomial distribution of Sec. 3.1.

        points: n x 3, in edge lengths (`in_edge_lengths`)
        graph: edges of the mesh (`mesh_graph`)
        normals: n x 3, unit vectors (`vertex_normals`), zero by default; used only with `inputs=6`
        """
        x = points
        if self.sizes["point_sampler_inputs"] == 6:
            x = torch.cat([points, torch.zeros_like(points) if normals is None else normals], 1)
        for layer in range(self.sizes["point_sampler_layers"]):
            x = getattr(self, f"dev_conv_{layer}")(x, graph)
        return self.score(x if self.hidden is None else self.hidden(x).relu())[:, 0]


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
        super().__init__()
        drawn = self._draw_weights(seed, width=width, attention_width=attention_width, knn=knn)
        self.dev_conv = DevConv(3, width)
        self.attention = SparseAttention(width, attention_width)
        self.load_state_dict(drawn)

    def forward(self, points: Any, graph: Any, product: Product) -> Edges:
        """Returns S and A_s along the entries of G_ext.

        points: n x 3, the samples, in lengths of the edges between samples (`in_edge_lengths`)
        graph: G_ext (`extend`)
        product: terms of Eq. (3) (`extend`)
        """
        attention = self.attention(self.dev_conv(points, graph), graph)
        slots = attention.new_zeros(product.slots.shape[0]).index_add(0, product.parts[1], attention.index_select(0, product.parts[0]))
        entries, places, others = product.terms
        upper = torch.zeros_like(attention).index_add(0, entries, slots.index_select(0, places) * attention.index_select(0, others))
        return Edges(attention, upper[product.mirror])

    def extend(self, points: Any, edges: Any, batch: Any = None) -> tuple[Any, Product]:
        """Returns G_ext over the samples (n x 3), and the terms of Eq. (3) on it, with A the graph `edges`."""
        graph = extended_graph(points, edges, self.sizes["edge_knn"], batch)
        return graph, product_terms(graph, edges, len(points))


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
        super().__init__()
        drawn = self._draw_weights(seed, layers=layers, width=width, knn=knn, candidates=candidates)
        for layer in range(layers):
            self.add_module(f"tri_conv_{layer}", TriConv(width if layer else 1, width))
        self.output = Affine(width, 1)
        self.load_state_dict(drawn)

    def forward(self, points: Any, faces: Any, prior: Any, graph: Any) -> Any:
        """Returns the probability of each candidate face, n_faces, from 0 to 1.

        points: n x 3, the samples, as for the Edge Predictor
        faces: n_faces x 3, candidates with ascending corners (`candidate_faces`)
        prior: n_faces, p_init of Sec. 3.2: `adjacency[candidates.entries].mean(1)`
        graph: G_tri (`triangle_graph`)
        """
        positions, x = triangle_positions(points, faces), prior[:, None]
        for layer in range(self.sizes["face_classifier_layers"]):
            x = getattr(self, f"tri_conv_{layer}")(positions, x, graph)
        return self.output(x)[:, 0].sigmoid()

    def join(self, points: Any, faces: Any, batch: Any = None) -> Any:
        """Returns G_tri over the candidate faces."""
        return triangle_graph(points, faces, self.sizes["face_knn"], batch)

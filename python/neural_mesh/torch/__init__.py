"""The paper's system as a layer of PyTorch (`Simplifier`), its losses (`losses`), and gradients of the library's results.

The layer runs on the device of its tensors, in PyTorch's operators. `positions` and `pool` differentiate records; `expected` estimates
the gradient of any objective of the default assembly. These two run in the library, on the processor.
"""

from . import losses
from ._expected import expected
from ._fine_tuning import FineTuned, fine_tune_scores
from ._graphs import CandidateFaces, Product, candidate_faces, extended_graph, in_edge_lengths, mesh_graph, triangle_graph, vertex_normals
from ._nearest import nearest_neighbours, nearest_to
from ._network import DevConv, EdgePredictor, Edges, FaceClassifier, PointSampler, SparseAttention, TriConv, triangle_positions
from ._records import pool, positions
from ._regions import Quotient, assign_to_samples, quotient
from ._sampling import inclusion
from ._simplifier import Candidates, Simplified, Simplifier
from ._smoothing import smooth_points

__all__ = [
    "CandidateFaces",
    "Candidates",
    "DevConv",
    "EdgePredictor",
    "Edges",
    "FaceClassifier",
    "FineTuned",
    "PointSampler",
    "Product",
    "Quotient",
    "Simplified",
    "Simplifier",
    "SparseAttention",
    "TriConv",
    "assign_to_samples",
    "candidate_faces",
    "expected",
    "extended_graph",
    "fine_tune_scores",
    "in_edge_lengths",
    "inclusion",
    "losses",
    "mesh_graph",
    "nearest_neighbours",
    "nearest_to",
    "pool",
    "positions",
    "quotient",
    "smooth_points",
    "triangle_graph",
    "triangle_positions",
    "vertex_normals",
]

"""Simplifies triangle meshes: if the input is closed and manifold, so is the result.

>>> import neural_mesh as nm
>>> light = nm.simplify((vertices, faces), ratio=0.1)   # doctest: +SKIP
>>> v, f = light                                        # doctest: +SKIP

Sizes say how much of the mesh remains. A mesh is a file, a pair of arrays, or an object of trimesh, Open3D, pyvista, meshio or PyMeshLab. `docs/python.md` is the guide.
"""

from ._compare import Comparison, compare, show
from ._faces import find_clean_faces
from ._learn import Sample, train
from ._native import NeuralMeshError, OptionError, __version__
from ._points import mesh_points
from ._progression import Progression, load_progression, progression
from ._record import Record, record
from ._report import Report, report_schema
from ._result import Light, Map, NeuralMeshWarning, NotReachedError
from ._simplify import lods, simplify, simplify_many

__all__ = [
    "Comparison",
    "Light",
    "Map",
    "NeuralMeshError",
    "NeuralMeshWarning",
    "NotReachedError",
    "OptionError",
    "Progression",
    "Record",
    "Report",
    "Sample",
    "__version__",
    "compare",
    "find_clean_faces",
    "load_progression",
    "lods",
    "mesh_points",
    "progression",
    "record",
    "report_schema",
    "show",
    "simplify",
    "simplify_many",
    "train",
]

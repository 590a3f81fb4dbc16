"""The accessor `mesh.neural` of pyvista: importing this module gives it to every `pyvista.PolyData`.

>>> import neural_mesh.pyvista                      # doctest: +SKIP
>>> light = mesh.neural.simplify(ratio=0.1)         # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyvista as pv

from . import Comparison, compare, lods, simplify

__all__ = ["Neural"]


class Neural:
    """What neural-mesh does with a `pyvista.PolyData`."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh

    def simplify(self, **options: Any) -> Any:
        """As `neural_mesh.simplify`; gives a `PolyData`."""
        return simplify(self._mesh, **options).mesh

    def lods(self, ratios: Sequence[float | str], **options: Any) -> list[Any]:
        """As `neural_mesh.lods`; gives `PolyData`."""
        return [light.mesh for light in lods(self._mesh, ratios, **options)]

    def compare(self, *simplified: Any, **options: Any) -> Comparison:
        """As `neural_mesh.compare`, with this mesh as the original."""
        return compare(self._mesh, *simplified, **options)


if hasattr(pv, "register_dataset_accessor"):
    pv.register_dataset_accessor("neural", pv.PolyData)(Neural)
else:
    # Before pyvista had accessors: one for each look, as it holds nothing.
    pv.PolyData.neural = property(Neural)

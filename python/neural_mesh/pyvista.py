"""Registers the accessor `mesh.neural` on every `pyvista.PolyData` when imported.

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
    """The methods of `mesh.neural` on a `pyvista.PolyData`."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh

    def simplify(self, **options: Any) -> Any:
        """Calls `neural_mesh.simplify` and returns a `PolyData`."""
        return simplify(self._mesh, **options).mesh

    def lods(self, ratios: Sequence[float | str], **options: Any) -> list[Any]:
        """Calls `neural_mesh.lods` and returns a `PolyData` per level."""
        return [light.mesh for light in lods(self._mesh, ratios, **options)]

    def compare(self, *simplified: Any, **options: Any) -> Comparison:
        """Calls `neural_mesh.compare` with this mesh as the original."""
        return compare(self._mesh, *simplified, **options)


if hasattr(pv, "register_dataset_accessor"):
    pv.register_dataset_accessor("neural", pv.PolyData)(Neural)
else:
    # Older pyvista has no accessors; a new object per access is fine, as it holds only the mesh.
    pv.PolyData.neural = property(Neural)

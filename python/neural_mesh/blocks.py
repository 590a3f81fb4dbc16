"""Simplifies one large mesh with many workers: cuts it into blocks, simplifies each, joins them, and simplifies across the borders.

>>> from neural_mesh import blocks
>>> vertices, faces = blocks.simplify(mesh, ratio=0.01, each=pool.map)   # doctest: +SKIP

`each` maps a function over blocks: `map`, the `map` of a pool, or `neural_mesh.ray.each`. Each call sends one `Block` and a few
numbers. Engines that keep blocks in place can call the steps themselves: `cut`, `sample`, `price`, `lighten`, `join`. Results do not
depend on the workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import read_input
from ._native import OptionError
from ._simplify import simplify as _simplify

TIMES = 2.0
"""Vertices of the joined blocks over the requested number, as the joined mesh is simplified once more."""
_SAMPLE_EVERY, _MAX_SAMPLES = 8, 8
"""Blocks sampled to estimate the price: one in `_SAMPLE_EVERY`, at most `_MAX_SAMPLES`."""

Each = Callable[[Callable[["Block"], Any], Sequence["Block"]], Iterable[Any]]
"""Calls a function on each block and returns the results in the blocks' order."""


@dataclass(frozen=True)
class Block:
    """A connected region of a mesh, about half a million faces."""

    vertices: NDArray[np.float32]
    """Positions relative to the origin of the `Cut`, n x 3."""
    faces: NDArray[np.int32]
    """Vertices of the triangles, m x 3."""
    shared: NDArray[np.bool_]
    """Whether each vertex also belongs to other blocks, n; these vertices do not move."""

    @property
    def _arrays(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.bool_]]:
        faces = np.ascontiguousarray(self.faces, np.uint32)
        return np.ascontiguousarray(self.vertices, np.float32), faces, np.ascontiguousarray(self.shared, np.bool_)


@dataclass(frozen=True)
class Cut:
    """A mesh in blocks."""

    blocks: list[Block]
    origin: NDArray[np.float64]
    """Offset from positions in blocks to those of the mesh, 3."""
    n_vertices: int
    """Number of vertices of the mesh, with equal positions counted once."""


@dataclass(frozen=True)
class Paid:
    """The prices of a sampled block's merges."""

    n_vertices: int
    n_shared: int
    paid: list[tuple[int, float]]
    """Vertices left, falling, and the price of the merge that led there: squared distance times area."""


def cut(mesh: Any) -> Cut:
    """Cuts a mesh of any type that `neural_mesh.simplify` takes into blocks, without attributes."""
    source = read_input(mesh, None, None)
    blocks, origin, n_vertices = _native.cut(source.path, source.arrays)
    return Cut([Block(*block) for block in blocks], np.array(origin), n_vertices)


def sample(block: Block, share: float, *, scores: Literal["bending", "network", "geometry"] = "bending", threads: int | None = None) -> Paid:
    """Simplifies a block to a share of its vertices and returns the prices; a few blocks suffice to estimate the price for all."""
    return Paid(*_native.sample_block(block._arrays, share, scores, threads))


def price(samples: Sequence[Paid], share: float) -> float:
    """Returns the price at which the sampled blocks together keep a share of their vertices."""
    return _native.price_for([(paid.n_vertices, paid.n_shared, paid.paid) for paid in samples], share)


def lighten(
    block: Block, share: float, price: float, *, scores: Literal["bending", "network", "geometry"] = "bending", threads: int | None = None
) -> Block:
    """Simplifies a block by merges up to a price; `share` is the mean share of vertices that all blocks keep at it."""
    return Block(*_native.simplify_block(block._arrays, share, price, scores, threads))


def join(blocks: Iterable[Block]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Joins blocks into vertices (n x 3) and faces (m x 3), relative to the origin of the cut; a closed mesh stays closed."""
    return _native.join([block._arrays for block in blocks])


def simplify(
    mesh: Any, *, ratio: float, each: Each = map, scores: Literal["bending", "network", "geometry"] = "bending", threads: int | None = None
) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Simplifies a mesh to a share of its vertices in blocks, and returns vertices (n x 3) and faces (m x 3).

    `mesh` is any mesh that `neural_mesh.simplify` takes, or a `Cut`; `each` runs the blocks. Raises `OptionError` for a wrong ratio."""
    if not 0 < ratio <= 1:
        raise OptionError(f"ratio: {ratio}: give a number above 0 and up to 1")
    whole = mesh if isinstance(mesh, Cut) else cut(mesh)
    settings: dict[str, Any] = {"scores": scores, "threads": threads}
    share = min(TIMES * ratio, 1.0)
    n = len(whole.blocks)
    n_samples = min(-(-n // _SAMPLE_EVERY), _MAX_SAMPLES)
    chosen = [whole.blocks[(2 * i + 1) * n // (2 * n_samples)] for i in range(n_samples)]
    samples = list(each(partial(sample, share=share / TIMES, **settings), chosen))
    lighter = each(partial(lighten, share=share, price=price(samples, share), **settings), whole.blocks)
    n_vertices = max(int(ratio * whole.n_vertices), 1)
    light = _simplify(join(lighter), vertices=n_vertices, scores=scores, threads=threads)
    vertices = light.vertices + whole.origin if whole.origin.any() else light.vertices
    return vertices, light.faces

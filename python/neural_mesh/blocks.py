"""One mesh by many workers: cut into blocks, each simplified for itself, joined, simplified across the borders to the size asked for.

>>> from neural_mesh import blocks
>>> vertices, faces = blocks.simplify(mesh, ratio=0.01, each=pool.map)   # doctest: +SKIP

`each` calls a function on every item of a list, somewhere: `map`, a pool's `map`, `neural_mesh.ray.each`. What it sends is a
`Block` and a few numbers. The steps stand for themselves, too, for engines that keep blocks where they are: `cut`, `sample`,
`price`, `lighten`, `join`. Results depend on the mesh alone, not on who made them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._meshes import given
from ._native import OptionError
from ._simplify import simplify as _simplify

TIMES = 2.0
"""Vertices that the blocks leave altogether, over those asked for: what is joined is simplified once more."""
_ONE_OF, _MOST = 8, 8
"""Of how many blocks one tells the price, and how many do at most."""

Each = Callable[[Callable[["Block"], Any], Sequence["Block"]], Iterable[Any]]
"""Calls a function on each block, and gives what it gave in their order."""


@dataclass(frozen=True)
class Block:
    """Some half a million faces of a mesh."""

    vertices: NDArray[np.float32]
    """n x 3, from the origin of its `Cut`."""
    faces: NDArray[np.int32]
    """n x 3."""
    shared: NDArray[np.bool_]
    """Whether each vertex is one of other blocks, too: those stay where they are."""

    @property
    def _arrays(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.bool_]]:
        faces = np.ascontiguousarray(self.faces, np.uint32)
        return np.ascontiguousarray(self.vertices, np.float32), faces, np.ascontiguousarray(self.shared, np.bool_)


@dataclass(frozen=True)
class Cut:
    """A mesh in blocks."""

    blocks: list[Block]
    origin: NDArray[np.float64]
    """What is added to the vertices of blocks to have those of the mesh, 3."""
    n_vertices: int
    """Vertices of the mesh, those in one place as one."""


@dataclass(frozen=True)
class Paid:
    """What a block pays on its way to a size."""

    n_vertices: int
    n_shared: int
    paid: list[tuple[int, float]]
    """How many vertices merges left, falling, and what the last of them cost: squared distance times area."""


def cut(mesh: Any) -> Cut:
    """Cuts a mesh, of any kind that `neural_mesh.simplify` takes, into blocks: its shape alone."""
    taken = given(mesh, None, None)
    blocks, origin, n_vertices = _native.cut(taken.path, taken.arrays)
    return Cut([Block(*block) for block in blocks], np.array(origin), n_vertices)


def sample(block: Block, share: float, *, scores: Literal["bending", "network", "geometry"] = "bending", seed: int = 0, threads: int | None = None) -> Paid:
    """What a block pays on the way to a share of its vertices; a few blocks tell the price for all."""
    return Paid(*_native.sample_block(block._arrays, share, scores, seed, threads))


def price(samples: Sequence[Paid], share: float) -> float:
    """The price at which these blocks keep a share of their vertices altogether."""
    return _native.price_for([(paid.n_vertices, paid.n_shared, paid.paid) for paid in samples], share)


def lighten(
    block: Block, share: float, price: float, *, scores: Literal["bending", "network", "geometry"] = "bending", seed: int = 0, threads: int | None = None
) -> Block:
    """Simplifies a block as long as merges cost no more than the price; `share` is what that leaves in the mean of all blocks."""
    return Block(*_native.simplify_block(block._arrays, share, price, scores, seed, threads))


def join(blocks: Iterable[Block]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Blocks as one mesh, from the origin of their cut: where the mesh was closed, so is what is joined."""
    return _native.join([block._arrays for block in blocks])


def simplify(
    mesh: Any, *, ratio: float, each: Each = map, scores: Literal["bending", "network", "geometry"] = "bending", seed: int = 0, threads: int | None = None
) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """Simplifies a mesh to a share of its vertices in blocks that `each` gives to workers; vertices and faces of the result."""
    if not 0 < ratio <= 1:
        raise OptionError(f"ratio: {ratio}: give a number above 0 and up to 1")
    whole = mesh if isinstance(mesh, Cut) else cut(mesh)
    settings: dict[str, Any] = {"scores": scores, "seed": seed, "threads": threads}
    share = min(TIMES * ratio, 1.0)
    n = len(whole.blocks)
    n_samples = min(-(-n // _ONE_OF), _MOST)
    chosen = [whole.blocks[(2 * i + 1) * n // (2 * n_samples)] for i in range(n_samples)]
    samples = list(each(partial(sample, share=share / TIMES, **settings), chosen))
    lighter = each(partial(lighten, share=share, price=price(samples, share), **settings), whole.blocks)
    n_vertices = max(int(ratio * whole.n_vertices), 1)
    light = _simplify(join(lighter), vertices=n_vertices, scores=scores, seed=seed, threads=threads)
    vertices = light.vertices + whole.origin if whole.origin.any() else light.vertices
    return vertices, light.faces

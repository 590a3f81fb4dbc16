# The compiled module: words of a request and arrays in, arrays out. Private; `neural_mesh` is what people import.
from collections.abc import Callable, Sequence
from typing import Any, final

from typing_extensions import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "NeuralMeshError",
    "OptionError",
    "Outcome",
    "Kept",
    "Meshed",
    "Record",
    "simplify",
    "compare",
    "mesh_points",
    "record",
    "train",
    "estimate",
    "shipped_default",
]

__version__: str

class NeuralMeshError(ValueError): ...
class OptionError(NeuralMeshError): ...

_Mesh: TypeAlias = tuple[
    NDArray[np.float32] | NDArray[np.float64],
    NDArray[np.uint32],
    NDArray[np.uint32] | None,
    Sequence[tuple[str, str, NDArray[np.float32]]],
    NDArray[np.uint32] | None,
]
_Progress: TypeAlias = Callable[[float, str], object]

@final
class Outcome:
    @property
    def results(self) -> list[Kept]: ...
    @property
    def report(self) -> str: ...
    @property
    def cleaned(self) -> str: ...
    @property
    def file_vertices(self) -> NDArray[np.int32] | None: ...
    @property
    def group_names(self) -> list[tuple[str, int]]: ...
    @property
    def paths(self) -> list[str]: ...
    @property
    def unmet(self) -> str | None: ...

@final
class Kept:
    @property
    def vertices(self) -> NDArray[Any]: ...
    @property
    def faces(self) -> NDArray[np.int32]: ...
    @property
    def wedges(self) -> NDArray[np.int32] | None: ...
    @property
    def channels(self) -> list[tuple[str, str, NDArray[np.float32]]]: ...
    @property
    def groups(self) -> NDArray[np.int32] | None: ...
    @property
    def sources(self) -> NDArray[np.int32] | None: ...
    @property
    def map(self) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]] | None: ...

@final
class Meshed:
    @property
    def vertices(self) -> NDArray[Any]: ...
    @property
    def faces(self) -> NDArray[np.int32]: ...
    @property
    def sources(self) -> NDArray[np.int32]: ...
    @property
    def report(self) -> str: ...

@final
class Record:
    @property
    def faces(self) -> NDArray[np.int32]: ...
    def positions(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def backward(self, vertices: NDArray[np.float64], gradient: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def output_vertices(self) -> NDArray[np.int32]: ...
    def sizes(self) -> list[int]: ...

def record(
    words: Sequence[str], mesh: _Mesh, threads: int | None, progress: _Progress | None
) -> Record: ...
def simplify(
    words: Sequence[str],
    mesh: _Mesh | None,
    importance: NDArray[np.float32] | None,
    threads: int | None,
    progress: _Progress | None,
) -> Outcome: ...
def compare(
    words: Sequence[str], meshes: Sequence[_Mesh | None], writes: bool, threads: int | None
) -> tuple[str, str | None]: ...
def mesh_points(
    words: Sequence[str],
    points: NDArray[np.float32] | NDArray[np.float64] | None,
    threads: int | None,
    progress: _Progress | None,
) -> Meshed: ...
def train(
    asked: tuple[str, str, str | None, str | None, int | None, bool],
    judge: Callable[..., NDArray[np.float64]] | None,
    init: bytes | None,
    threads: int | None,
    progress: Callable[[str, int, int, int, Any], object] | None,
) -> bool: ...
def estimate(
    mesh: _Mesh,
    scores: NDArray[np.float32],
    ratio: float,
    judge: Callable[..., NDArray[np.float64]],
    settings: str,
    seed: int,
    threads: int | None,
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]: ...
def shipped_default() -> bytes: ...

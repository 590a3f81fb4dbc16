# Types of the compiled module, which takes and returns options and arrays. It is private: import `neural_mesh` instead.
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

from typing_extensions import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "NeuralMeshError",
    "OptionError",
    "Outcome",
    "ResultArrays",
    "PlainResult",
    "Meshed",
    "Progression",
    "Record",
    "simplify",
    "simplify_plain",
    "compare",
    "mesh_points",
    "progression",
    "read_progression",
    "record",
    "train",
    "cut",
    "sample_block",
    "price_for",
    "simplify_block",
    "join",
    "estimate",
    "shipped_weights",
    "random_weights",
    "read_weights",
    "weights_bytes",
    "paper_stages",
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
    def results(self) -> list[ResultArrays]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def cleaned(self) -> str: ...
    @property
    def file_vertices(self) -> NDArray[np.int32] | None: ...
    @property
    def group_names(self) -> list[tuple[str, int]]: ...
    @property
    def paths(self) -> list[str]: ...
    @property
    def bytes(self) -> bytes | None: ...
    @property
    def unmet(self) -> str | None: ...

@final
class ResultArrays:
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
class PlainResult:
    @property
    def vertices(self) -> NDArray[Any]: ...
    @property
    def faces(self) -> NDArray[np.int32]: ...
    @property
    def n_used(self) -> int: ...
    @property
    def threads(self) -> int: ...
    @property
    def error(self) -> float: ...
    @property
    def seconds(self) -> float: ...
    @property
    def target(self) -> dict[str, Any]: ...
    @property
    def origins(self) -> NDArray[np.int32]: ...
    @property
    def became(self) -> NDArray[np.int32] | None: ...

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
class Progression:
    def level(self, options: dict[str, Any], files: dict[str, Any], threads: int | None) -> Outcome: ...
    def save(self, path: Any, force: bool) -> None: ...
    def to_bytes(self) -> bytes: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def proved_levels(self) -> list[tuple[int, float]]: ...

@final
class Record:
    @property
    def faces(self) -> NDArray[np.int32]: ...
    def positions(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def backward(self, vertices: NDArray[np.float64], gradient: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def output_vertices(self) -> NDArray[np.int32]: ...
    def sizes(self) -> list[int]: ...

def progression(
    options: dict[str, Any],
    files: dict[str, Any],
    mesh: _Mesh | None,
    file: tuple[bytes, str] | None,
    importance: NDArray[np.float32] | None,
    prove: bool,
    threads: int | None,
    progress: _Progress | None,
) -> Progression: ...
def read_progression(bytes: bytes) -> Progression: ...
def record(
    options: Mapping[str, Any], files: Mapping[str, Any], mesh: _Mesh, threads: int | None, progress: _Progress | None
) -> Record: ...
def simplify(
    options: Mapping[str, Any],
    files: Mapping[str, Any],
    mesh: _Mesh | None,
    file: tuple[bytes, str] | None,
    importance: NDArray[np.float32] | None,
    threads: int | None,
    progress: _Progress | None,
) -> Outcome: ...
def simplify_plain(
    options: Mapping[str, Any],
    meshes: Sequence[tuple[NDArray[np.float32] | NDArray[np.float64], NDArray[np.uint32]]],
    n_fit_steps: int,
    locks_boundaries: bool,
    welds: bool,
    keeps_merges: bool,
    threads: int | None,
    progress: _Progress | None,
) -> list[PlainResult | None] | None: ...
def compare(
    paths: Sequence[str],
    meshes: Sequence[_Mesh | None],
    *,
    samples: int,
    seed: int,
    weld: bool,
    html: str | None,
    writes: bool,
    force: bool,
    threads: int | None,
) -> tuple[str, str | None]: ...
def mesh_points(
    input: str,
    points: NDArray[np.float32] | NDArray[np.float64] | None,
    *,
    ratio: float | str | None,
    vertices: int | str | None,
    keep_points: bool,
    out: str | None,
    format: str | None,
    weights: str | None,
    seed: int,
    force: bool,
    threads: int | None,
    progress: _Progress | None,
) -> Meshed: ...
def train(
    arguments: tuple[str, str, str | None, str | None, int | None, bool],
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

# Sizes by name, tensors by name, and the trained objective, if known.
_Weights: TypeAlias = tuple[list[tuple[str, int]], list[tuple[str, NDArray[np.float32]]], str | None]
# Sizes and tensors of a stage or of the whole network.
_Tensors: TypeAlias = tuple[Mapping[str, int], Sequence[tuple[str, NDArray[np.float32]]]]

def shipped_weights(name: str) -> _Weights: ...
def random_weights(sizes: Mapping[str, int], seed: int) -> _Weights: ...
def read_weights(bytes: bytes) -> _Weights: ...
def weights_bytes(given: _Tensors, objective: str | None) -> bytes: ...
def paper_stages(
    vertices: NDArray[np.float32],
    faces: NDArray[np.int64],
    n_samples: int,
    weights: bytes,
    seed: int,
    threads: int | None,
) -> dict[str, NDArray[Any]]: ...

_Block: TypeAlias = tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.bool_]]
_Cut: TypeAlias = tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.bool_]]
_Paid: TypeAlias = tuple[int, int, list[tuple[int, float]]]

def cut(path: str | None, mesh: Any) -> tuple[list[_Cut], list[float], int]: ...
def sample_block(block: _Block, share: float, scores: str, threads: int | None) -> _Paid: ...
def price_for(samples: Sequence[_Paid], share: float) -> float: ...
def simplify_block(block: _Block, share: float, price: float, scores: str, threads: int | None) -> _Cut: ...
def join(blocks: Sequence[_Block]) -> tuple[NDArray[np.float32], NDArray[np.int32]]: ...

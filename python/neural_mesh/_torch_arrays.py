"""Tensors of PyTorch as arrays of numpy, on the processor, where everything is computed."""

from __future__ import annotations

import warnings
from typing import Any

import torch

_IS_SAID = False


def as_numpy(tensor: Any, dtype: Any) -> Any:
    """The numbers of a tensor as a contiguous array of this type of torch; those of a GPU are copied, which is said once."""
    if tensor.device.type != "cpu":
        _say_copied(tensor.device)
    return tensor.detach().to("cpu", dtype).contiguous().numpy()


def _say_copied(device: Any) -> None:
    global _IS_SAID
    if not _IS_SAID:
        _IS_SAID = True
        warnings.warn(f"neural_mesh computes on the processor: tensors are copied from {device} and back", stacklevel=3)

"""Converts PyTorch tensors to numpy arrays on the CPU, where the library computes."""

from __future__ import annotations

import warnings
from typing import Any

import torch

_HAS_WARNED = False


def as_numpy(tensor: Any, dtype: Any) -> Any:
    """Returns a tensor as a contiguous array of a torch dtype; warns once if it has to be copied from a GPU."""
    if tensor.device.type != "cpu":
        _warn_copied(tensor.device)
    return tensor.detach().to("cpu", dtype).contiguous().numpy()


def _warn_copied(device: Any) -> None:
    global _HAS_WARNED
    if not _HAS_WARNED:
        _HAS_WARNED = True
        warnings.warn(f"neural_mesh computes on the processor: tensors are copied from {device} and back", stacklevel=3)

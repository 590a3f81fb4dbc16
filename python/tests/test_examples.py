"""The programs in `python/examples` run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("torch")

import neural_mesh.torch as nmt  # noqa: E402

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(name: str, *arguments: str) -> str:
    return subprocess.run([sys.executable, EXAMPLES / name, *arguments], capture_output=True, text=True, check=True).stdout


def test_training(tmp_path: Path) -> None:
    said = run("train_layer.py", "--epochs", "1", "--out", str(tmp_path / "mine.safetensors")).splitlines()
    assert said[0].startswith("epoch 1: sampler 0.") and said[1].startswith("held out, ratio 0.1: distance")
    assert nmt.Simplifier.from_weights(tmp_path / "mine.safetensors").objective == "paper"


def test_fine_tuning(spot: Path) -> None:
    said = run("fine_tune.py", str(spot), "--ratios", "0.05", "--steps", "3", "--draw", "multinomial").splitlines()
    assert said[0].startswith("spot.ply, 2930 vertices, 0.05: error ") and said[1].startswith("ratio 0.05, medians of 1: error ")


def test_times() -> None:
    assert "faces to" in run("layer_times.py", "--faces", "2000").splitlines()[-1]

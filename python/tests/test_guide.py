"""The code blocks of the guides run, one after another."""

from __future__ import annotations

import importlib.util
import re
import shutil
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
RECIPES = DOCS / "python.md"


def run_page(page: str) -> None:
    """Runs the code blocks of a page as one program, without those whose packages are not installed."""
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / page).read_text(), re.DOTALL)
    assert len(blocks) >= 2
    names: dict[str, object] = {}
    for block in blocks:
        if "torch" in block and importlib.util.find_spec("torch") is None:
            continue
        exec(compile(block, page, "exec"), names)


def test_the_guide(spot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(spot, "scan.ply")
    run_page("python.md")
    assert Path("light.glb").exists() and Path("page.html").exists()


def test_the_guide_for_researchers(
    spot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("data").mkdir()
    shutil.copy(spot, "data/spot.ply")
    run_page("guide/researcher.md")
    assert capsys.readouterr().out.startswith("200 reached")

"""The type checker accepts correct calls and finds mistakes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAD = """
import numpy as np
import neural_mesh as nm
v, f = np.zeros((3, 3)), np.zeros((1, 3), int)
"""
MISTAKES = [
    "nm.simplify(7, ratio=0.1)",
    "nm.simplify((v, f), ratio=0.1, faces=5)",
    "nm.compare((v, f), (v, f))['maen']",
    "nm.simplify((v, f), ration=0.1)",
    "nm.simplify((v, f), ratio=[0.1])",
    "nm.simplify((v, f), faces=0.5)",
    "nm.simplify((v, f), ratio=0.1, optimize='fastest')",
    "nm.simplify((v, f), ratio=0.1, ignore=['uvs'])",
    "nm.simplify((v, f), ratio=0.1, on_dirty='explode')",
    "nm.simplify((v, f), ratio=0.1, progress=lambda done: None)",
    "nm.simplify((v, f), ratio=0.1).vertces",
    "nm.simplify((v, f), ratio=0.1).mesh.vertices",
    "nm.simplify((v, f), ratio=0.1).report['outcom']",
    "nm.lods((v, f), 0.5)",
    "nm.show((v, f), (v, f), htm=True)",
    "nm.record(v, f, ratio=0.5).positons(v)",
]
RIGHT = [
    "nm.simplify([[0.0, 1.0, 2.0]], [[0, 0, 0]], ratio=0.1).mesh[0].shape",
    "nm.simplify(nm.simplify('a.ply', ratio=0.1), ratio=0.1).mesh[1].dtype",
    "nm.compare((v, f), (v, f))['flip']",
    "nm.simplify(v, f, ratio=np.float64(0.1), groups=f[:, 0]).mesh[0]",
    "nm.simplify('a.ply', faces='10%', out='b.ply', threads=2).report['output']['faces']",
    "nm.simplify(b'', error='0.5%', keep=['wheel'], ratio_of={'hull': 0.5})",
    "[light.reached for light in nm.simplify_many([(v, f)], ratio=0.1)]",
    "nm.record([v], [f], ratio=0.5)[0].faces",
]


def test_type_checker_finds_mistakes(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "case.py").write_text("\n".join([HEAD.strip(), *MISTAKES, *RIGHT]) + "\n")
    said = subprocess.run([sys.executable, "-m", "mypy", "--strict", "case.py"], cwd=tmp_path, capture_output=True, text=True).stdout
    found = {int(line.split(":")[1]) for line in said.splitlines() if ": error:" in line}
    first = len(HEAD.strip().splitlines()) + 1
    assert found == set(range(first, first + len(MISTAKES))), said
    assert len(said.splitlines()) <= 4 * len(MISTAKES)

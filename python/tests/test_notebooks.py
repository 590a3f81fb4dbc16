"""The notebooks run at a small size."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(notebook, tmp_path, monkeypatch):
    monkeypatch.setenv("NEURAL_MESH_SMALL", "1")
    monkeypatch.setenv("NEURAL_MESH_OUT", str(tmp_path))
    monkeypatch.chdir(notebook.parent)
    if "import torch" in notebook.read_text():
        pytest.importorskip("torch")
        pytest.importorskip("matplotlib").use("Agg")
    space = {"__name__": notebook.stem}
    for cell in json.loads(notebook.read_text())["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"{notebook.name}:{cell['id']}", "exec"), space)

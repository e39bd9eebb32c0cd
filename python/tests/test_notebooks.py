"""The notebooks as programs, and as notebooks in a kernel."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import wzvi

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"
pytestmark = [pytest.mark.compiled, pytest.mark.slow]


def environment():
    return {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": str(Path(wzvi.__file__).parents[1])}


@pytest.mark.parametrize("name", ["bath", "chaos_map", "work_precision"])
def test_programs(cache, tmp_path, name):
    pytest.importorskip("matplotlib")
    if name == "work_precision":
        pytest.importorskip("scipy")
    subprocess.run([sys.executable, NOTEBOOKS / f"{name}.py"], cwd=tmp_path, env=environment(), check=True)
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000


def cells(text):
    """The cells of a program in the percent format."""
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.v4.new_notebook()
    for part in text.split("# %%")[1:]:
        head, _, body = part.partition("\n")
        if "[markdown]" in head:
            prose = "\n".join(line.removeprefix("#").removeprefix(" ") for line in body.strip().split("\n"))
            notebook.cells.append(nbformat.v4.new_markdown_cell(prose))
        else:
            notebook.cells.append(nbformat.v4.new_code_cell(body.strip()))
    return notebook


def test_a_notebook_shows_equations_and_progress(cache, tmp_path, monkeypatch):
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    shutil.copy(NOTEBOOKS / "bath.py", tmp_path)
    notebook = cells((tmp_path / "bath.py").read_text(encoding="utf-8"))
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    html = "".join(output["data"].get("text/html", "") for output in outputs if "data" in output)
    text = "".join(output["data"].get("text/plain", "") for output in outputs if "data" in output)
    assert "kick of h/2" in html and "Rate of friction" in html and "<table>" in html and "100.0 % of 20000 paths" in text

"""The notebooks of the documentation and the example of the home page, executed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))
LARGEST = 200_000
"""Largest notebook in the repository [bytes]."""


def test_there_are_two_notebooks_without_outputs() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["first-fault", "your-detector"]
    for path in NOTEBOOKS:
        assert path.stat().st_size < LARGEST
        cells = [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
        assert [cell for cell in cells if cell.outputs or cell.execution_count] == [], "clear the outputs: the site makes them anew"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_executes(path: Path) -> None:
    notebook = nbformat.read(path, 4)
    NotebookClient(notebook, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(ROOT)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 1
    assert [output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"] == []


def five_lines() -> str:
    """Return the code of the example of the home page."""
    return (ROOT / "examples" / "first_fault.py").read_text(encoding="utf-8").split('"""\n\n', 1)[1]


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_home_pages_show_the_five_lines(page: str) -> None:
    assert len([line for line in five_lines().splitlines() if line]) == 5
    assert f"```python\n{five_lines()}```" in (ROOT / page).read_text(encoding="utf-8")


def test_five_lines_show_a_first_fault(tmp_path: Path) -> None:
    command, environment = [sys.executable, str(ROOT / "examples" / "first_fault.py")], {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("<DetectionResult: outer_ring")
    assert (tmp_path / "spectrum.png").read_bytes()[:4] == b"\x89PNG"

"""The notebooks of the documentation, which the site executes when it is built, and the example of the home page."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest

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


def built(page: str, output: str, *, execute: bool = True) -> str:
    """Return a page as the hook of the site leaves it."""
    spec = importlib.util.spec_from_file_location("hooks", ROOT / "docs" / "hooks.py")
    assert spec is not None
    assert spec.loader is not None
    hooks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hooks)
    config = SimpleNamespace(plugins={"mkdocs-jupyter": SimpleNamespace(config={"execute": execute})})
    return str(hooks.on_post_page(output, page=SimpleNamespace(file=SimpleNamespace(src_uri=page)), config=config))


def test_the_site_refuses_a_notebook_without_a_figure_or_with_warnings() -> None:
    plugins = pytest.importorskip("mkdocs.exceptions", reason="the site needs the extra docs")
    figure = '<style>div[data-mime-type="application/vnd.jupyter.stderr"]{}</style><img src="data:image/png;base64,iVBORw0K">'
    assert built("first.ipynb", figure) == figure
    assert built("page.md", "text") == "text"
    assert built("first.ipynb", "text", execute=False) == "text"
    with pytest.raises(plugins.PluginError, match=r"first\.ipynb shows no figure"):
        built("first.ipynb", "text")
    with pytest.raises(plugins.PluginError, match=r"first\.ipynb prints warnings"):
        built("first.ipynb", figure + '<div data-mime-type="application/vnd.jupyter.stderr">')


def five_lines() -> str:
    """Return the code of the example of the home page."""
    return (ROOT / "examples" / "first_fault.py").read_text(encoding="utf-8").split('"""\n\n', 1)[1]


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_home_pages_show_the_five_lines(page: str) -> None:
    assert len([line for line in five_lines().splitlines() if line]) == 5
    assert f"```python\n{five_lines()}```" in (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.slow
def test_five_lines_show_a_first_fault(tmp_path: Path) -> None:
    command, environment = [sys.executable, str(ROOT / "examples" / "first_fault.py")], {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("<DetectionResult: outer_ring")
    assert (tmp_path / "spectrum.png").read_bytes()[:4] == b"\x89PNG"

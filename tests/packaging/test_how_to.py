"""The tests of the extension pages in a package that has the extension, as after following the page."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from how_to import ROOT, blocks, copied_package, followed

PAGES = sorted((ROOT / "docs/how-to").glob("add-*.md"))


def package(folder: Path) -> Path:
    """Return a small package with one registry."""
    (folder / "dcrb_ros").mkdir(parents=True)
    (folder / "dcrb_ros/registry.py").write_text('RULES = (\n    "cage",\n)\n', encoding="utf-8")
    return folder


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "add-a-rule.md"
    path.write_text(
        '```python title="dcrb_ros/rub.py"\nDEPTH = 0.3\n```\n\n```diff title="dcrb_ros/registry.py"\n     "cage",\n+    "rub",\n )\n```\n',
        encoding="utf-8",
    )
    return path


def content(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in (folder / "dcrb_ros").iterdir()}


def test_a_page_is_applied_once(page: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    copied_package(first, page, package(tmp_path / "root"))
    assert content(first) == {"registry.py": 'RULES = (\n    "cage",\n    "rub",\n)\n', "rub.py": "DEPTH = 0.3\n"}
    assert not capsys.readouterr().out
    # The copy is now the package of someone who has followed the page, and changed its file.
    (first / "dcrb_ros/rub.py").write_text("DEPTH = 0.4\n", encoding="utf-8")
    copied_package(second, page, first)
    assert content(second) == content(first)
    assert "the package has this extension already; it is tested as it is" in capsys.readouterr().out


def test_a_page_is_applied_beside_another_extension(page: Path, tmp_path: Path) -> None:
    root = package(tmp_path / "root")
    (root / "dcrb_ros/registry.py").write_text('RULES = (\n    "cage",\n    "hum",\n)\n', encoding="utf-8")
    copied_package(tmp_path / "copy", page, root)
    assert content(tmp_path / "copy")["registry.py"] == 'RULES = (\n    "cage",\n    "rub",\n    "hum",\n)\n'


def test_a_page_that_does_not_fit_the_package_is_refused(page: Path, tmp_path: Path) -> None:
    root = package(tmp_path / "root")
    for text, sentence in (("RULES = ()\n", "contains 0 times, instead of once"), ('RULES = [\n    "cage",\n]\n', "behind the change")):
        (root / "dcrb_ros/registry.py").write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=sentence):
            copied_package(tmp_path / sentence, page, root)


def test_a_page_followed_in_part_is_refused_with_what_is_missing(page: Path, tmp_path: Path) -> None:
    root = package(tmp_path / "root")
    (root / "dcrb_ros/rub.py").write_text("DEPTH = 0.3\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"has dcrb_ros/rub\.py and lacks the line in dcrb_ros/registry\.py\. Add what is missing"):
        copied_package(tmp_path / "copy", page, root)


@pytest.mark.parametrize("extension", PAGES, ids=lambda path: path.stem)
def test_a_page_is_followed_wholly_or_not_at_all(extension: Path) -> None:
    assert followed(extension) in (True, False)


@pytest.mark.parametrize("extension", PAGES, ids=lambda path: path.stem)
def test_the_new_files_satisfy_the_linter(extension: Path, tmp_path: Path) -> None:
    ruff = [sys.executable, "-m", "ruff"]
    for block in blocks(extension):
        if not block.changes:
            path = tmp_path / block.path
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.code, encoding="utf-8")
    for check in (["check"], ["format", "--check"]):
        subprocess.run([*ruff, *check, "--config", str(ROOT / "pyproject.toml"), str(tmp_path)], check=True)

"""The folders in which the Makefile looks for marked tests."""

from __future__ import annotations

from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]


@pytest.mark.parametrize(("mark", "folder"), [("kernel", "core"), ("node", "nodes")])
def test_marked_tests_are_in_the_folder_of_their_mark(mark: str, folder: str) -> None:
    marked = {path.relative_to(TESTS).parts[0] for path in TESTS.rglob("test_*.py") if f"pytest.mark.{mark}" in path.read_text("utf-8")}
    assert marked == {folder}

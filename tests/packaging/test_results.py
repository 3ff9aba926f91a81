"""Pages of results say when, on which version and by which command their numbers were made."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).parents[2] / "docs" / "results").glob("*.md"))
PROVENANCE = {
    "date": r"\b\d{1,2} (?:January|February|March|April|May|June|July|August|September|October|November|December) 20\d\d\b",
    "commit": r"\b(?:commits?|model) `[0-9a-f]{7,}`",
    "command": r"`(?:make|dcrb|python|benchmarks/|tests/)[^`]*`|```sh",
}


def missing(text: str) -> list[str]:
    """Return what a page of results leaves out."""
    joined = " ".join(text.split())
    return [name for name, pattern in PROVENANCE.items() if not re.search(pattern, joined)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_of_results_has_date_commit_and_command(page: Path) -> None:
    assert missing(page.read_text(encoding="utf-8")) == []


def test_a_page_without_them_is_noticed() -> None:
    assert missing("`make exam` made these numbers on 3 May 2026\n(commit `0123abc`).") == []
    assert missing("The detector finds 3 of 4 faults.") == ["date", "commit", "command"]

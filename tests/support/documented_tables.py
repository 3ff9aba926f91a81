"""Tables of numbers in the documentation, which tests compare with the code."""

from __future__ import annotations

from pathlib import Path

PAGES = Path(__file__).parents[2] / "docs"


def rows_of(page: str, heading: str) -> list[list[str]]:
    """Return the cells of the first table under a heading of a page, such as ``explanation/lubrication.md``, without its head."""
    text = (PAGES / page).read_text(encoding="utf-8")
    section = text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    rows = [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines[2:]]
    assert rows, f"{page} has no table under {heading}"
    return rows


def half_unit(cell: str) -> float:
    """Return half a unit in the last place of a printed number such as 0.93 or 1.5e4."""
    digits, _, exponent = cell.partition("e")
    decimals = len(digits.partition(".")[2])
    # A tenth more for the rounding of the number itself.
    return 0.55 * 10.0 ** (int(exponent or 0) - decimals)

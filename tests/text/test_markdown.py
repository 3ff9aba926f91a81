"""Markdown tables."""

from __future__ import annotations

from dcrb_ros.text.markdown import table


def test_a_table_has_a_rule_below_its_heads_and_cells_as_text() -> None:
    assert table(("split", "runs"), [("train", 2), ("test", 1.5)]) == "| split | runs |\n|---|---|\n| train | 2 |\n| test | 1.5 |"


def test_a_table_without_rows_has_heads_only() -> None:
    assert table(["name"], []) == "| name |\n|---|"

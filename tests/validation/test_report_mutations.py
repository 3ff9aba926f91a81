"""The table of rows that notice a change of the benches: `benchmarks/report_mutations.py`."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest
import report_mutations

from dcrb_ros.validation.report_row import ReportRow


def test_a_row_that_falls_short_without_a_change_does_not_notice_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def comparisons(settings: tuple[str, ...]) -> Iterator[ReportRow]:
        for quantity, holds in (("RMS", True), ("power", not settings), ("slip", False)):
            yield ReportRow(quantity, "pocket", "-", "1", "2", holds)

    monkeypatch.setattr(report_mutations, "comparisons", comparisons)
    monkeypatch.setattr(sys, "argv", ["report_mutations.py", "viscosity x 2"])
    report_mutations.main()
    assert capsys.readouterr().out.splitlines()[2:] == ["| viscosity x 2 | 1 of 2 | power (1) |"]

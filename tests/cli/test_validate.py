"""`dcrb validate`: the table, JSON and the exit status, of made-up comparisons."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from full_disk import files_of_at_most
from same_process import dcrb

from dcrb_ros.validation import validate
from dcrb_ros.validation.report_row import ReportRow

HOLDS = ReportRow("spin [rad/s]", "pocket", "-", "1.0", "1.0 +- 1 %", True)
SHORT = ReportRow("force [N]", "both", "2 (Fig. 8)", "3", "2", False, "Oil")


@pytest.fixture(params=[[HOLDS], [HOLDS, SHORT]], ids=["all hold", "one falls short"])
def comparisons(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> list[ReportRow]:
    found: list[ReportRow] = request.param
    monkeypatch.setattr(validate, "run_all", lambda processes, on_done: (on_done(1, 1, "run [s]"), validate.Results({}, {}, {}))[1])
    monkeypatch.setattr(validate, "all_rows", lambda results: found)
    monkeypatch.setattr(validate, "write_figures", lambda runs, folder: [])
    return found


def test_the_comparisons_as_json(comparisons: list[ReportRow], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = all(comparison.holds for comparison in comparisons)
    assert dcrb("validate", "-o", str(tmp_path), "--json", "--quiet") == (0 if good else 1)
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert err == ""
    assert found["holds"] == good
    assert [row["quantity"] for row in found["comparisons"]] == [comparison.quantity for comparison in comparisons]
    assert found["comparisons"][0]["verdict"] == "holds"
    assert found["comparisons"][-1]["chapter"] == comparisons[-1].chapter


def test_the_table_has_units(comparisons: list[ReportRow], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = all(comparison.holds for comparison in comparisons)
    assert dcrb("validate", "-o", str(tmp_path)) == (0 if good else 1)
    out, err = capsys.readouterr()
    assert "spin [rad/s]" in out
    assert "run [s]" in err
    assert all(comparison.chapter in out for comparison in comparisons)
    assert f"Report: {tmp_path / 'report.md'}" in out


@pytest.mark.parametrize("old", [False, True], ids=["new", "replaced"])
def test_a_full_disk_fails_and_leaves_the_earlier_report(
    comparisons: list[ReportRow], old: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if old:
        (tmp_path / "report.md").write_text("old")
    with files_of_at_most(200):
        assert dcrb("validate", "-o", str(tmp_path), "--quiet") == 2
    assert capsys.readouterr().err.count("File too large") == 1
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == ([("report.md", "old")] if old else [])

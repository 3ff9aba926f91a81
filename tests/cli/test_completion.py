"""Shell completion of commands, shipped names and parameters."""

from __future__ import annotations

import pytest
from same_process import dcrb


def completed(line: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what bash offers for the last word of a line."""
    monkeypatch.setenv("_DCRB_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split(" ")) - 1))
    assert dcrb() == 0
    return capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("dcrb simu", ["simulate"]),
        ("dcrb simulate inner", ["inner_ring_defect"]),
        ("dcrb bench comp", ["compound"]),
        ("dcrb config show cage_", ["cage_fracture"]),
        ("dcrb simulate healthy --scenario run_", ["run_up"]),
        ("dcrb simulate healthy --set operating.speed_k", ["operating.speed_kmh="]),
        ("dcrb score smo", ["smoke"]),
        ("dcrb score --exam smo", ["smoke"]),
        ("dcrb sweep two", ["two_hundred"]),
        ("dcrb bench --vehicle healthy_b", ["healthy_bogie"]),
        ("dcrb exam replica table.csv --bench ball", ["ball_bearing_6205"]),
        ("dcrb simulate no_such", []),
    ],
)
def test_names_are_completed(line: str, offered: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert completed(line, capsys, monkeypatch) == offered


def test_all_shipped_names_of_a_kind_are_offered_in_order(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    offered = completed("dcrb simulate ", capsys, monkeypatch)
    assert offered == sorted(offered)
    assert {"healthy", "paper", "outer_ring_defect"} <= set(offered)
    assert "detector" not in offered  # parameters of the detector, not a configuration


def test_a_script_for_the_shell_is_printed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_DCRB_COMPLETE", "source_bash")
    assert dcrb() == 0
    assert "complete -o default -F _dcrb_completion dcrb" in capsys.readouterr().out

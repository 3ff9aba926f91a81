"""The tables and sentences of the commands as a user reads them."""

from __future__ import annotations

from pathlib import Path

import pytest
from same_process import dcrb

from dcrb_ros.exam import evaluation
from dcrb_ros.exam.evaluation import Outcome

BAGS = Path(__file__).parents[2] / "bags"


def output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return what a command prints to the standard output."""
    assert dcrb(*arguments) == 0
    return capsys.readouterr().out


def test_the_diagnosis_has_units_and_names_every_fault(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "detect", str(BAGS / "compound"))
    assert "level over background [dB]" in shown
    assert "over threshold [dB]" in shown
    assert "several faults: inner ring defect, outer ring defect" in " ".join(shown.split())
    assert "m/s^2 (baseline 38 m/s^2, both at a shaft frequency of 20 Hz)" in shown
    assert len([line for line in shown.splitlines() if line.startswith("compound, confidence")]) == 1


def test_the_contents_of_a_recording_have_units(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "info", str(BAGS / "compound"))
    assert "sampling rate: 51200 Hz" in shown
    assert "units: acceleration [m/s^2], angle [rad], speed [rad/s], force [N], time [s, simulated, from zero]" in shown


def test_the_list_of_scenarios_has_units(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "score", "smoke", "--list")
    assert "onset [s]" in shown
    assert "duration [s]" in shown


def test_a_quiet_score_prints_the_report_only(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation, "in_processes", lambda calls, workers: [(name, Outcome()) for name in calls])
    for arguments, expected in ((["--quiet"], ""), ([], "scenarios evaluated")):
        assert dcrb("score", str(BAGS / "healthy"), "--reference", *arguments) == 1  # without a diagnosis
        out, err = capsys.readouterr()
        assert "criterion" in out
        assert expected in err
        assert bool(err) == bool(expected)

"""The tables and sentences of the commands as a user reads them."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from same_process import dcrb

from dcrb_ros.cli.detect import _print_table
from dcrb_ros.cli.detect_vehicle import print_vehicle, vehicle_as_object
from dcrb_ros.diagnosis.detection import DetectionResult
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.detection import VehicleDetectionResult
from dcrb_ros.exam import evaluation
from dcrb_ros.exam.evaluation import Outcome
from dcrb_ros.schema.printable import decimal
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_diagnosis import Status, VehicleDiagnosis

BAGS = Path(__file__).parents[2] / "bags"


def truncated(bag: str, folder: Path) -> Path:
    """Return a shipped recording that was cut off after 0.7 of its file."""
    cut = folder / bag
    shutil.copytree(BAGS / bag, cut)
    (file,) = cut.glob("*.mcap")
    file.write_bytes(file.read_bytes()[: int(0.7 * file.stat().st_size)])
    return cut


def output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return what a command prints to the standard output."""
    assert dcrb(*arguments) == 0
    return capsys.readouterr().out


def test_a_picture_of_a_truncated_recording_is_announced_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("plot", str(truncated("healthy", tmp_path)), "-o", str(tmp_path / "cut.png")) == 0
    assert "is truncated or damaged; its readable part was drawn" in capsys.readouterr().err


def test_the_verdicts_on_a_truncated_vehicle_are_announced_as_such(capsys: pytest.CaptureFixture[str]) -> None:
    result = VehicleDetectionResult((VehicleDiagnosis(0, 1.0, {"axle_1/left/bearing": Status("waiting", "no signal")}, {}),))
    for damage, announced in (([], False), (["the end is missing"], True)):
        recording = SimpleNamespace(damage=damage, boxes={}, stored=[])
        print_vehicle(Path("run"), recording, result)  # type: ignore[arg-type]
        assert ("the recording is truncated or damaged" in capsys.readouterr().out) is announced
        assert vehicle_as_object(recording, result)["complete"] is not announced  # type: ignore[arg-type]


def test_the_diagnosis_has_units_and_names_every_fault(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "detect", str(BAGS / "compound"))
    assert all(head in shown for head in ("level [dB]", "depth [-]", "threshold [-]", "excess [dB]"))
    (row,) = (line for line in shown.splitlines() if "outer_ring" in line and "│" in line)
    assert [cell.strip() for cell in row.split("│")[3:7]] == ["34.3", "0.942", "0.17", "7.4"]
    assert "a fault is suspected from 0 dB on" in " ".join(shown.split())
    assert "several faults: outer ring defect, inner ring defect" in " ".join(shown.split())
    assert "m/s^2 (baseline 38 m/s^2, both at a shaft frequency of 20 Hz)" in shown
    assert len([line for line in shown.splitlines() if line.startswith("compound, confidence")]) == 1


def test_evidence_that_is_not_confirmed_is_not_called_a_fault() -> None:
    scores = {"outer_ring": 5.0, "inner_ring": 4.0, "roller": -3.0, "cage": 0.5}
    faults = "outer_ring", "inner_ring"
    assert Diagnosis(0, 1.0, "compound", "", scores=scores, faults=faults).title == "several faults: outer ring defect, inner ring defect"


def test_a_diagnosis_by_temperatures_alone_has_no_table_of_lines(capsys: pytest.CaptureFixture[str]) -> None:
    hot = Diagnosis(0, 1.0, "overheating", "it overheats", scores={"overheating": 3.0, "lubrication": -5.0})
    recording = SimpleNamespace(complete=True)
    _print_table(Path("hot"), recording, DetectionResult((hot,), 1.0), DetectorParameters(), learned=False)  # type: ignore[arg-type]
    shown = capsys.readouterr().out
    assert shown.startswith("hot: overheating\noverheating, confidence 0.00, first at 1.00 s")
    assert "depth" not in shown


def test_the_contents_of_a_recording_have_units(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "info", str(BAGS / "compound"))
    assert "sampling rate: 51200 Hz" in shown
    assert "units: acceleration [m/s^2], angle [rad], speed [rad/s], force [N], time [s, simulated, from zero]" in shown


def test_the_list_of_scenarios_has_units(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "score", "smoke", "--list")
    assert "onset [s]" in shown
    assert "duration [s]" in shown


def without_notes(err: str) -> str:
    """Return what a command printed on standard error, except that the shipped recordings have no digest of their manifest."""
    return "".join(line for line in err.splitlines(keepends=True) if not line.startswith("note: "))


def test_a_quiet_score_prints_the_report_only(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation, "in_processes", lambda calls, workers: [(name, Outcome()) for name in calls])
    for arguments, expected in ((["--quiet"], ""), ([], "scenarios evaluated")):
        assert dcrb("score", str(BAGS / "healthy"), "--reference", *arguments) == 1  # without a diagnosis
        out, err = capsys.readouterr()
        assert "criterion" in out
        assert expected in err
        assert bool(without_notes(err)) == bool(expected)


def test_a_comparison_gives_the_depth_of_each_fault_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("compare", str(BAGS / "inner_ring_defect"), str(BAGS / "outer_ring_defect")) == 0
    shown, progress = capsys.readouterr()
    rows = [[cell.strip() for cell in line.split("│")[1:5]] for line in shown.splitlines() if "│" in line]
    assert [row[:2] for row in rows] == [[line, axis] for line in ("BPFO", "BPFI", "2BSF", "FTF") for axis in "xy"]
    depth = {(line, axis): (float(first), float(second)) for line, axis, first, second in rows}
    assert depth["BPFI", "y"][0] > 2.0 * depth["BPFI", "y"][1]
    assert depth["BPFO", "y"][1] > 2.0 * depth["BPFO", "y"][0]
    assert "4/4" in progress


def test_a_quiet_comparison_shows_no_progress(capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("compare", "--quiet", str(BAGS / "healthy"), str(BAGS / "healthy")) == 0
    assert without_notes(capsys.readouterr().err) == ""


def test_what_rounds_to_zero_has_no_sign() -> None:
    assert [decimal(value, 1) for value in (-0.04, 0.0, -0.0, -0.06, 2.25)] == ["0.0", "0.0", "0.0", "-0.1", "2.2"]


def test_help_groups_the_commands_by_purpose(capsys: pytest.CaptureFixture[str]) -> None:
    shown = output(capsys, "--help")
    heads = [line.strip("╭╮─ ") for line in shown.splitlines() if line.startswith("╭")]
    assert heads == ["Options", "Simulate", "Recordings", "Detect and evaluate", "Data sets", "Configuration"]


def test_exam_run_is_score_and_overlapping_commands_name_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys, "exam", "run", "smoke", "--list") == output(capsys, "score", "smoke", "--list")
    for command, other in (("score", "exam"), ("collect", "import"), ("import", "collect")):
        assert f"dcrb {other}" in output(capsys, command, "--help")

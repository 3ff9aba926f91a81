"""An option that would have no effect is refused: each command with each option that does not apply to what the others ask for."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from made_up_blocks import recorded
from same_process import dcrb

from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the recording of a bench, ``bag``, and one of a vehicle, ``run``."""
    folder = tmp_path_factory.mktemp("recordings")
    recorded(folder / "bag", 3)
    parameters = read_parameters("healthy_bogie", ())
    VehicleRecorder(folder / "run", parameters, VehicleSimulation(vehicle_of(parameters, "test"))).close()
    return folder


FROM, NODES = ("simulate", "--from", "bag"), "has no effect without nodes"
DRY, REMAKE = ("sweep", "two_hundred", "--dry-run"), ("shards", "index.json", "-o", "new", "--remake", "train-000000.tar")
LIST, RECORDED, VEHICLE = ("score", "smoke", "--list"), ("score", "bag"), ("detect", "run")


@pytest.mark.parametrize(
    ("command", "option", "sentence"),
    [
        (FROM, ("--duration", "3"), "--duration does not apply to --from"),
        (FROM, ("--set", "simulation.seed=2"), "leave out CONFIG, --vehicle, --set and --scenario"),
        (FROM, ("--scenario", "run_up"), "leave out CONFIG, --vehicle, --set and --scenario"),
        (FROM, ("--vehicle", "bogie"), "leave out CONFIG, --vehicle, --set and --scenario"),
        (("simulate", "--from", "run"), ("--duration", "3"), "--duration does not apply to --from"),
        (("simulate", "dry"), ("--set", "time_scale=2.0"), NODES),
        (("simulate", "dry"), ("--set", "recording.path=other"), NODES),
        (("simulate", "dry"), ("--set", "recording.queue=20"), NODES),
        (("simulate", "dry"), ("--set", "publishing.clock=true"), NODES),
        (("simulate", "dry"), ("--set", "publishing.listeners=1"), NODES),
        (("simulate", "--vehicle", "bogie"), ("--set", "publishing.wait=5.0"), NODES),
        (("simulate", "--vehicle", "bogie"), ("--set", "time_scale=2.0"), NODES),
        (("simulate", "dry"), ("--set", "recording.topics=diagnosis"), "recording.topics: this run does not record 'diagnosis'"),
        (("simulate", "--vehicle", "bogie"), ("--set", "recording.topics=roller_contacts"), "does not record 'roller_contacts'"),
        (("simulate", "--vehicle", "bogie"), ("dry",), "leave out CONFIG"),
        (("bench", "--vehicle", "bogie"), ("dry",), "leave out CONFIG"),
        (("bench", "dry", "--time-scale", "2"), ("--set", "time_scale=3.0"), "--time-scale and --set time_scale set the same parameter"),
        (("bench", "dry", "--record", "new"), ("--set", "recording.path=other"), "--record and --set recording.path set the same"),
        (("bench", "--vehicle", "bogie", "--time-scale", "2"), ("--set", "time_scale=3.0"), "set the same parameter"),
        (("view", "bag", "--save", "new.rrd"), ("--web",), "--web opens a viewer"),
        (("view", "bag", "--screenshot", "new.png"), ("--web",), "--web opens a viewer"),
        (("view", "run", "--save", "new.rrd"), ("--web",), "--web opens a viewer"),
        (("view", "bag"), ("--force",), "--force has no effect without --save or --screenshot"),
        (("compare", "bag", "bag"), ("--force",), "--force has no effect without -o"),
        (FROM, ("--force",), "--force has no effect without -o"),
        (("detect", "bag"), ("--force",), "--force has no effect without --report or --save-baseline"),
        (("bench", "dry"), ("--force",), "--force has no effect without --record"),
        (("bench", "--vehicle", "bogie"), ("--force",), "--force has no effect without --record"),
        (("detect", "bag"), ("--save-baseline", "new.yaml"), "--save-baseline needs --healthy"),
        (("detect", "bag", "--healthy", "bag"), ("--baseline", "new.yaml"), "both give a baseline"),
        (
            ("detect", "bag", "--healthy", "bag"),
            ("--detector", "detector.yaml"),
            "the baseline old.yaml in --detector both give a baseline",
        ),
        (("detect", "bag", "--detector", "detector.yaml"), ("--baseline", "new.yaml"), "the baseline old.yaml in --detector both give"),
        *((VEHICLE, (option, "new.yaml"), f"to which {option} does not") for option in ("--healthy", "--baseline", "--save-baseline")),
        (VEHICLE, ("--report", "new.html"), "to which --report does not"),
        (VEHICLE, ("--detector", "detector.yaml"), "baseline = old.yaml is the baseline of a single bearing"),
        (("score", "smoke"), ("--speed", "lines"), "--speed applies to --measured only"),
        (("score", "smoke"), ("--rate", "1"), "--rate applies to --node only"),
        (("score", "smoke", "--python", "dcrb_ros:FaultDetector"), ("--patience", "3"), "--patience applies to --node only"),
        (("score", "--measured", "."), ("--rate", "1"), "--rate applies to --node only"),
        *(
            (("score", "smoke"), (f"--{name}-limit", "500"), f"--{name}-limit applies to --python only")
            for name in ("block", "scenario", "memory")
        ),
        *((LIST, option, f"{option[0]} does not apply to --list") for option in (("--json",), ("--node", "x"), ("--name", "x"))),
        *((LIST, (option, "new.png"), f"{option} does not apply to --list") for option in ("--junit", "--figure", "--recordings")),
        *((LIST, option, f"{option[0]} does not apply to --list") for option in (("--entry", "new.json"), ("--workers", "1"))),
        (LIST, ("--force",), "--force does not apply to --list"),
        *((RECORDED, option, "the diagnoses in the recordings are scored") for option in (("--name", "x"), ("--workers", "1"))),
        (("score", "run"), ("--reference",), "is the recording of a vehicle, which cannot be scored"),
        (("score", "run/axle_1.left"), ("--reference",), "is a box in the recording of a vehicle, which cannot be scored"),
        (("score", "smoke", "--only", "a"), ("--only", "b"), "--only is given more than once"),
        (("simulate", "-o", "new1"), ("--output", "new2"), "--output is given more than once"),
        (("simulate", "dry", "-o", "new", "--set", "operating.speed=100"), ("--set", "operating.speed=50"), "once, as 100 and 50"),
        (("import", "a.csv", "--about", "mfpt", "-o", "new", "--set", "gap=1"), ("--set", "gap=2"), "--set gap is given more than once"),
        (("score", "smoke"), ("--force",), "--force has no effect without --junit, --figure or --entry"),
        (("exam", "predictivity", "a.csv"), ("--force",), "--force has no effect without --output or --figure"),
        (("score", "smoke", "--entry", "new.json"), ("--junit", "./new.json"), "--junit and --entry both name new.json"),
        (("exam", "predictivity", "a.csv", "-o", "new.png"), ("--figure", "new.png"), "--output and --figure both name new.png"),
        (DRY, ("-o", "new"), "--output does not apply to --dry-run"),
        (DRY, ("--scheduler", "tcp://127.0.0.1:1"), "--scheduler does not apply to --dry-run"),
        (DRY, ("--memory", "2GB"), "--memory does not apply to --dry-run"),
        (("sweep", "two_hundred", "-o", "new", "--scheduler", "tcp://127.0.0.1:1"), ("--workers", "2"), "leave out --workers and --memory"),
        (REMAKE, ("--runs", "3"), "--runs does not apply to --remake"),
        (("import", "--list"), ("--about", "cwru-12k"), "leave out everything else"),
        (("import", "--show", "cwru-12k"), ("--set", "a=1"), "leave out everything else"),
        (("import", "--list"), ("--force",), "leave out everything else"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_an_option_without_effect_is_refused(
    command: tuple[str, ...],
    option: tuple[str, ...],
    sentence: str,
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name in ("bag", "run"):
        shutil.copytree(folder / name, tmp_path / name)
    (tmp_path / "detector.yaml").write_text("fault_detector:\n  ros__parameters:\n    baseline: old.yaml\n")
    monkeypatch.chdir(tmp_path)
    assert dcrb(*command, *option) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("dcrb: ") == 1
    assert not list(tmp_path.glob("new*"))

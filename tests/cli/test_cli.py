"""The command line as a user runs it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
import yaml
from made_up_blocks import BODIES, blocks
from separate_process import dcrb, fresh_dcrb

from dcrb_ros.cli.app import main
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.configuration import Configuration


def test_help_lists_the_commands_without_importing_their_dependencies() -> None:
    done = fresh_dcrb("--help")
    assert done.returncode == 0
    for command in ("simulate", "bench", "detect", "score", "view", "info", "config"):
        assert command in done.stdout
    heavy = {"numba", "rclpy", "rerun", "scipy", "rosbags", "pydantic"}
    code = f"import sys; import dcrb_ros.cli.app; print(sorted({heavy} & set(sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=400, check=True)
    assert loaded.stdout.strip() == "[]"


def test_a_diagnosis_imports_neither_the_kernels_nor_what_it_does_not_use() -> None:
    unused = {
        "numba",
        "dcrb_ros.core",
        "pandas",
        "matplotlib",
        "rclpy",
        "rerun",
        "scipy.signal",
        "scipy.optimize",
        "scipy.stats",
        "scipy.linalg",
    }
    bag = Path(__file__).parents[2] / "bags" / "outer_ring_defect"
    code = "import sys; from pathlib import Path; from dcrb_ros.cli import detect; "
    code += f"detect.detect([Path({str(bag)!r})]); print(sorted({unused} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=400, check=True)
    assert "outer_ring, confidence" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_lists_and_completion_of_what_is_shipped_import_neither_the_kernels_nor_the_parameters() -> None:
    code = (
        "import sys; from dcrb_ros.cli import completion, config; config.list_(); "
        "print(completion.configurations('pa'), completion.exams('smo'), sorted({'numba', 'numpy', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=400, check=True)
    assert done.stdout.splitlines()[-1] == "['paper'] ['smoke'] []"
    assert "outer_ring_defect" in done.stdout


def test_a_simulated_recording_can_be_diagnosed_and_described(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    done = fresh_dcrb("simulate", "inner_ring_defect", "-o", str(bag), "--duration", "3", "--set", "simulation.seed=7")
    assert done.returncode == 0, done.stderr
    assert Recording(bag).configuration.simulation.seed == 7
    found = fresh_dcrb("detect", str(bag), "--json")
    assert found.returncode == 0, found.stderr
    about = json.loads(found.stdout)
    assert about["verdict"] == "inner_ring"
    assert about["complete"] is True
    info = fresh_dcrb("info", str(bag))
    assert "/dcrb/outer_ring/vibration" in info.stdout
    assert "faults.inner_1.width" in info.stdout
    again = dcrb("simulate", "healthy", "-o", str(bag))
    assert again.returncode == 2
    assert "exists: give another name" in again.stderr


def test_a_recording_that_is_too_short_for_a_verdict_is_refused(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    assert dcrb("simulate", "healthy", "-o", str(bag), "--duration", "0.5").returncode == 0
    done = dcrb("detect", str(bag))
    assert done.returncode == 2
    assert f"{bag} holds 0.50 s of waveform, too little for a verdict: give at least 1 s" in done.stderr
    answered = dcrb("detect", str(bag), "--json")
    assert answered.returncode == 0
    assert json.loads(answered.stdout)["verdict"] == "waiting"


def test_a_verdict_on_a_recording_that_begins_late_states_its_time_and_the_length_of_the_signal(tmp_path: Path) -> None:
    bag = str(tmp_path / "bag")
    with Recorder(bag, Configuration(), BODIES) as recorder:
        for block in islice(blocks(400), 250, None):
            recorder.write(block)
    said = dcrb("detect", bag).stdout
    time, length = map(float, re.findall(r"first at ([\d.]+) s, in ([\d.]+) s of signal", said)[0])
    assert length == 3.0
    assert 5.0 < time <= 8.0
    about = json.loads(dcrb("detect", bag, "--json").stdout)
    assert (about["recording"], about["duration"]) == (bag, 3.0)
    assert about["first_time"] == pytest.approx(time, abs=0.005)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["simulat"], "simulat"),
        (["simulate"], "Missing argument"),
        (["simulate", "heathy"], "did you mean 'healthy'?"),
        (["simulate", "healthy", "--duration", "nan"], "--duration nan s is not a finite number"),
        (["simulate", "healthy", "--duration", "-1"], "--duration -1 s is out of range"),
        (["simulate", "healthy", "--duration", "long"], "--duration"),
        (["simulate", "healthy", "--set", "bearing.roller_radius=15.0"], "did you mean 0.015?"),
        (["detect", "nothing"], "there is no recording nothing"),
        (["info", "/dev/null"], "is not an MCAP file"),
        (["bench", "healthy", "--time-scale", "-1"], "time_scale = -1.0 is outside 0 .. 1000"),
        (["config", "check", "healthy", "--set", "operating.sped=1"], "did you mean 'operating.speed'?"),
    ],
)
def test_invalid_usage_is_refused_in_one_sentence(arguments: list[str], sentence: str) -> None:
    done = dcrb(*arguments)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ("faults: {outer_1: {width: 0.002}, outer_2: {width: 0.002}}", "overlaps faults.outer_1"),
        ("faults: {broken_bars: row1/bar15 and row2/bar15}", "'and' is not a bar"),
        ("bearing: {outer_raceway_radius: 0.1}", "check the three radii"),
        ("bearing: {roller_mass: 0.02, roller_inertia: 2.25e-6}", "is too long for a roller between the raceways"),
    ],
)
def test_a_configuration_with_contradictory_values_is_refused_in_one_sentence(tmp_path: Path, parameters: str, sentence: str) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(f"/**: {{ros__parameters: {{{parameters}}}}}\n", encoding="utf-8")
    done = dcrb("config", "check", str(path))
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("name", ["paper", "healthy", "outer_ring_defect", "inner_ring_defect"])
def test_shipped_recordings_are_diagnosed_correctly(name: str) -> None:
    bag = Path(__file__).parents[2] / "bags" / name
    verdicts = {"outer_ring_defect": "outer_ring", "inner_ring_defect": "inner_ring"}
    assert json.loads(dcrb("detect", str(bag), "--json").stdout)["verdict"] == verdicts.get(name, "healthy")
    assert Recording(bag).manifest["seed"] == 1


def test_options_of_the_bench_override_the_configuration_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    runs: list[tuple[Configuration, DetectorParameters]] = []

    def run(bench: Any, configuration: Configuration, *others: Any) -> int:
        runs.append((configuration, bench.detector[1]))
        return 0

    monkeypatch.setattr("dcrb_ros.nodes.bench.run", run)
    mine, file = tmp_path / "mine.yaml", tmp_path / "file.yaml"
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"time_scale": 0.5, "recording": {"path": "kept"}}}}))
    file.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"learn": 10.0}}}))
    for options in ([], ["--set", "time_scale=0.25"], ["--time-scale", "0", "--record", "asked"], ["--detector", str(file)]):
        monkeypatch.setattr("sys.argv", ["dcrb", "bench", str(mine), *options])
        with pytest.raises(SystemExit) as end:
            main()
        assert end.value.code == 0
    assert [configuration.time_scale for configuration, _ in runs] == [0.5, 0.25, 0.0, 0.5]
    assert [configuration.recording.path for configuration, _ in runs] == ["kept", "kept", "asked", "kept"]
    assert [parameters.learn for _, parameters in runs] == [0.0, 0.0, 0.0, 10.0]
    file.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"window": 1.0, "hop": 2.0}}}))
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert "window = 1 s is below hop = 2 s" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "recording.path = kept exists: give another name"),
        (["--record", "asked"], "--record asked exists"),
        (["--record=~/asked"], "/asked exists"),
    ],
)
def test_a_bench_does_not_record_to_an_existing_folder(
    options: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It names the recording at the end, and a node takes the next free name."""
    monkeypatch.chdir(tmp_path)
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"recording": {"path": "kept"}}}}))
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("kept", "asked"):
        (tmp_path / name).mkdir()
    monkeypatch.setattr("sys.argv", ["dcrb", "bench", str(mine), *options])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert words in capsys.readouterr().err


def test_a_bench_replaces_the_folder_of_its_configuration_with_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(bench: Any, configuration: Configuration, *others: Any) -> int:
        Path(configuration.recording.path).mkdir()
        return 0

    monkeypatch.setattr("dcrb_ros.nodes.bench.run", run)
    monkeypatch.chdir(tmp_path)
    old = Path("kept", "kept_0.mcap")
    old.parent.mkdir()
    old.touch()
    monkeypatch.setattr("sys.argv", ["dcrb", "bench", "healthy", "--set", "recording.path=kept", "--force"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 0
    assert not old.exists()


def test_the_detector_reads_its_parameters_from_a_file(tmp_path: Path) -> None:
    bag, file = tmp_path / "bag", tmp_path / "file.yaml"
    assert dcrb("simulate", "outer_ring_defect", "-o", str(bag), "--duration", "2.6").returncode == 0
    file.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"outer_limit": 5000.0, "outer_limit_high": 5000.0}}}))
    verdicts = [json.loads(dcrb("detect", str(bag), "--json", *more).stdout)["verdict"] for more in ([], ["--detector", str(file)])]
    assert verdicts == ["outer_ring", "healthy"]
    file.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"outer_limt": 50.0}}}))
    refused = dcrb("detect", str(bag), "--detector", str(file))
    assert (refused.returncode, "did you mean" in refused.stderr, refused.stderr.count("\n")) == (2, True, 1), refused.stderr

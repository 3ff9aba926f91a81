"""A recording contains everything that is needed to reproduce it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_blocks import BODIES, blocks, recorded
from separate_process import dcrb, fresh_dcrb

from dcrb_ros import __version__
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.mathematics import FUNCTIONS
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.reproduction import NotReproduced, RecordedSamples, Reproduction, recorded_samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import scheduled_changes
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import Command, CommandSchedule, LoadCommand, ParameterChange, SpeedCommand, TimedCommand, UnknownCommand

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run with a command for speed, one for load and both at once."""
    path = tmp_path_factory.mktemp("bags") / "run"
    configuration = Configuration.model_validate(
        {"simulation": {"seed": 11}, "faults": {"inner_1": {"width": 0.002}}, "publishing": {"block_size": 700}}
    )
    simulation = Simulation(configuration)
    with Recorder(path, configuration, simulation.bodies) as recorder:
        for number, block in enumerate(simulation.blocks(0.4)):
            recorder.write(block)
            if number in (5, 20):
                simulation.command_speed(110.0 + number / 3.0)
            if number in (12, 20):
                simulation.command_load(-1e3 / 3.0, -80e3)
    return path


def test_the_manifest_describes_the_run(bag: Path) -> None:
    recording = Recording(bag)
    manifest, outcome = recording.manifest, recording.outcome
    assert outcome is not None
    assert manifest["model"] == model_fingerprint()
    assert manifest["seed"] == 11
    assert manifest["faults"]["inner_1"]["width"] == 0.002
    assert manifest["bearing"]["pitch_radius"] == 0.094
    assert manifest["bearing"]["radial_gap"] == pytest.approx(0.00028)  # Table 1 of Fan et al. 2025
    assert manifest["orders"]["BPFO"] == pytest.approx(6.7234, abs=1e-4)
    assert manifest["sensor"]["acceleration_unit"] == "m/s^2"
    assert manifest["sampling_rate"] == 51200
    samples = [np.column_stack([block.acceleration, block.shaft_angle]) for block in recording.vibrations()]
    assert outcome["sha256"] == hashlib.sha256(np.concatenate(samples).astype("<f4").tobytes()).hexdigest()
    load = LoadCommand(-1e3 / 3.0, -80e3)
    assert [timed.command for timed in recording.commands()] == [SpeedCommand(110.0 + 5 / 3.0), load, SpeedCommand(110.0 + 20 / 3.0), load]
    times = [command.time_ns for command in recording.commands()]
    assert times[2] == times[3]
    assert times == sorted(times)


def test_the_same_samples_are_reproduced(bag: Path, tmp_path: Path) -> None:
    done = fresh_dcrb("simulate", "--from", str(bag), "-o", str(tmp_path / "again"))
    assert done.returncode == 0, done.stderr
    assert "the same 20480 samples" in done.stdout
    old, new = Recording(bag), Recording(tmp_path / "again")
    assert [(m.topic, m.time_ns, m.data) for m in old.messages()] == [(m.topic, m.time_ns, m.data) for m in new.messages()]
    assert old.commands() == new.commands()


def test_scenario_and_changes_are_reproduced(tmp_path: Path) -> None:
    scenario = {"timeline": [{"at": 0.05, "over": 0.1, "set": {"faults.outer_1.width": 0.002}}]}
    configuration = Configuration.model_validate({"faults": {"outer_1": {"width": 0.0005}}})
    simulation = Simulation(configuration, scheduled_changes(scenario, configuration, "scenario"))
    with Recorder(tmp_path / "run", configuration, simulation.bodies, scenario=scenario) as recorder:
        for number, block in enumerate(simulation.blocks(0.4)):
            recorder.write(block)
            if number == 6:
                simulation.change({"faults.broken_bars": "row1/bar3", "sensor.noise_density": 0.01})
    commands = [timed.command for timed in Recording(tmp_path / "run").commands()]
    assert commands == [ParameterChange({"faults.broken_bars": "row1/bar3", "sensor.noise_density": 0.01})]
    done = dcrb("simulate", "--from", str(tmp_path / "run"))
    assert done.returncode == 0, done.stderr
    assert "the same 20480 samples" in done.stdout


def test_a_cut_off_recording_is_reproduced(bag: Path, tmp_path: Path) -> None:
    whole = (bag / "run_0.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: len(whole) - 9000])
    reproduction = Reproduction(Recording(path))
    assert 0 < reproduction.compared[""].recorded.count <= 20480
    simulation = Simulation(reproduction.configuration)
    for _ in reproduction.blocks(simulation):
        pass
    reproduction.check()


def test_different_samples_are_reported_with_the_reason(tmp_path: Path) -> None:
    made_up = recorded(tmp_path / "noise", 2)
    recording = Recording(made_up)
    recording.manifest["model"] = "0123456789abcdef"
    reproduction = Reproduction(recording)
    for _ in reproduction.blocks(Simulation(reproduction.configuration)):
        pass
    stated = reproduction.compared[""].recorded.sha256[:12]
    with pytest.raises(NotReproduced, match=rf"instead of {stated}.*with model 0123456789abcdef, this is"):
        reproduction.check()
    done = dcrb("simulate", "--from", str(made_up))
    assert done.returncode == 1
    assert "the samples differ from those of" in done.stderr
    assert "Traceback" not in done.stderr


def test_unknown_commands_are_refused(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 4, events={2: UnknownCommand("command/tilt 3.0 rad")})
    done = dcrb("simulate", "--from", str(bag))
    assert done.returncode == 2
    assert "the command 'command/tilt 3.0 rad' at 0.04 s, which this version does not know" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--from", "nothing"], "there is no recording nothing"),
        (["healthy", "--from", "nothing"], "leave out CONFIG"),
        ([], "Missing argument 'CONFIG'"),
    ],
)
def test_invalid_arguments_are_refused(arguments: list[str], sentence: str) -> None:
    done = dcrb("simulate", *arguments)
    assert done.returncode == 2
    assert sentence in done.stderr


def test_a_waveform_with_a_gap_cannot_be_compared(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 60)
    broken = bytearray((bag / "bag_0.mcap").read_bytes())
    broken[len(broken) // 2] ^= 0xFF
    path = tmp_path / "broken.mcap"
    path.write_bytes(broken)
    assert recorded_samples(Recording(path)).count == 60 * 1024  # from the outcome record
    recording = Recording(path)
    recording.__dict__["outcome"] = None
    with pytest.raises(Refusal, match="are missing, so it cannot be checked"):
        recorded_samples(recording)


def test_info_prints_the_manifest_as_text_and_as_json(bag: Path) -> None:
    words = dcrb("info", str(bag))
    assert words.returncode == 0, words.stderr
    for word in ("sha256", "BPFO 6.72340", "command/speed 111.66666666666667 rad/s", "publishing.block_size", "inner_1"):
        assert word in words.stdout
    about = json.loads(dcrb("info", str(bag), "--json").stdout)
    assert about["manifest"]["seed"] == 11
    assert about["damage"] == []
    assert len(about["commands"]) == 4


@pytest.mark.parametrize(("count", "where"), [(20_000, "manifest"), (300_000, "ground truth")])
def test_all_of_many_commands_are_kept(count: int, where: str, tmp_path: Path) -> None:
    """A controller may send a command with every block for hours."""
    before = [TimedCommand(k, SpeedCommand(float(k))) for k in range(count)]
    with Recorder(tmp_path / "bag", Configuration(), BODIES, commands=before) as recorder:
        for block in blocks(3, events={1: SpeedCommand(1.5)}):
            recorder.write(block)
    recording = Recording(tmp_path / "bag")
    assert recording.outcome is not None
    assert recording.outcome["command_count"] == count + 1
    found = recording.commands()
    assert found[-1].command == SpeedCommand(1.5)
    assert len(found) == (count + 1 if where == "manifest" else 1)


class CommandLog:
    """Keeps the commands it receives instead of simulating."""

    def __init__(self) -> None:
        self.time_ns = 0
        self.commands: list[Command] = []

    def command_speed(self, speed: float) -> None:
        self.commands.append(SpeedCommand(speed))

    def command_load(self, x: float, y: float) -> None:
        self.commands.append(LoadCommand(x, y))

    def change(self, changes: Mapping[str, Any]) -> None:
        self.commands.append(ParameterChange(changes))


def test_commands_are_applied_when_they_are_due_in_the_order_of_time() -> None:
    commands = [LoadCommand(1.0, -2.0), ParameterChange({"sensor.range": 100.0}), SpeedCommand(1.0)]
    log, schedule = CommandLog(), CommandSchedule([TimedCommand(30 - 10 * k, command) for k, command in enumerate(commands)])
    applied = []
    for time_ns in (0, 10, 19, 25, 30):
        log.time_ns = time_ns
        schedule.apply_due(log)
        applied.append(len(log.commands))
    assert applied == [0, 1, 1, 2, 3]
    assert log.commands == commands[::-1]


def with_outcome(recording: Recording, outcome: Mapping[str, Any] | None) -> Recording:
    """Return a recording with another outcome record."""
    recording.__dict__["outcome"] = outcome
    return recording


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        ({"first_index": 5, "samples": 7, "sha256": "ab", "end_index": 20}, (5, 7, "ab", 20)),
        ({"first_index": 5, "samples": 7, "sha256": "ab"}, (5, 7, "ab", 12)),
    ],
)
def test_range_and_hash_are_those_of_the_outcome(outcome: dict[str, Any], expected: tuple[int, int, str, int], tmp_path: Path) -> None:
    recording = with_outcome(Recording(recorded(tmp_path / "bag", 1)), outcome)
    assert recorded_samples(recording) == RecordedSamples(*expected)
    with pytest.raises(FrozenInstanceError):
        recorded_samples(recording).count = 0  # type: ignore[misc]


def late(path: Path, numbers: Sequence[int], **publishing: Any) -> Recording:
    """Record some of the blocks of noise; return the recording without its outcome."""
    configuration, made = Configuration.model_validate({"publishing": publishing}), list(blocks(8))
    with Recorder(path, configuration, BODIES) as recorder:
        for number in numbers:
            recorder.write(made[number])
    return with_outcome(Recording(path), None)


@pytest.mark.parametrize("outcome", [None, {}, {"first_index": 0, "samples": None, "sha256": ""}, {"first_index": "x"}])
def test_without_an_outcome_range_and_hash_are_those_of_the_waveform(outcome: dict[str, Any] | None, tmp_path: Path) -> None:
    made = list(blocks(5))[2:]
    samples = np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in made])
    recording = with_outcome(late(tmp_path / "bag", range(2, 5)), outcome)
    expected = RecordedSamples(2048, 3072, hashlib.sha256(samples.astype("<f4").tobytes()).hexdigest(), 5120)
    assert recorded_samples(recording) == expected


def test_a_gap_in_the_waveform_is_refused_with_its_samples(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=r"is damaged: the samples 2048 \.\. 4095 are missing, so it cannot be checked"):
        recorded_samples(late(tmp_path / "bag", (0, 1, 4, 5)))


@pytest.mark.parametrize("publishing", [{"loss_probability": 0.1}, {"burst_period": 1.0, "burst_length": 0.5}])
def test_gaps_are_accepted_where_blocks_are_lost_by_configuration(publishing: dict[str, float], tmp_path: Path) -> None:
    found = recorded_samples(late(tmp_path / "bag", (0, 1, 4), **publishing))
    assert (found.first_index, found.count, found.end) == (0, 3 * 1024, 5 * 1024)


@pytest.mark.parametrize("count", [0, 1])
def test_a_recording_without_samples_cannot_be_reproduced(count: int, tmp_path: Path) -> None:
    outcome = {"first_index": 0, "samples": count, "sha256": "ab"}
    recording = with_outcome(Recording(recorded(tmp_path / "bag", 1)), outcome)
    if count:
        assert Reproduction(recording).duration == pytest.approx(1.0 / 51200, rel=1e-12)
    else:
        with pytest.raises(Refusal, match="contains no samples to reproduce"):
            Reproduction(recording)


class Playback:
    """Yields blocks of noise instead of simulating."""

    def __init__(self, lost: int = -1) -> None:
        self.time_ns, self.lost = 0, lost

    def blocks(self, duration: float) -> Iterator[Block]:
        for number, block in enumerate(blocks(round(duration * 51200 / 1024))):
            yield replace(block, lost=number == self.lost)


@pytest.mark.parametrize(("first", "lost"), [(0, -1), (1, -1), (1024, -1), (1500, -1), (3000, -1), (1024, 3), (0, 0)])
def test_samples_are_compared_from_the_first_recorded_one_without_lost_blocks(first: int, lost: int, tmp_path: Path) -> None:
    rows = [np.column_stack([block.acceleration, block.shaft_angle]) for block in blocks(5)]
    kept = [row[max(0, first - 1024 * number) :] for number, row in enumerate(rows) if number != lost]
    digest = hashlib.sha256(np.concatenate(kept).astype("<f4").tobytes()).hexdigest()
    outcome = {"first_index": first, "samples": sum(map(len, kept)), "sha256": digest, "end_index": 5 * 1024}
    reproduction = Reproduction(with_outcome(Recording(recorded(tmp_path / "bag", 1)), outcome))
    compared = reproduction.compared[""]
    compared.recorded, compared.digests = recorded_samples(reproduction.recording), replace(compared.digests, stated=None)
    assert len(list(reproduction.blocks(Playback(lost)))) == 5  # type: ignore[arg-type]
    reproduction.check()


def test_a_difference_is_explained_by_version_model_or_software(tmp_path: Path) -> None:
    recording = Recording(recorded(tmp_path / "bag", 1))
    reproduction = Reproduction(recording)
    known = dict(recording.manifest)
    assert reproduction.difference() == ""
    with pytest.raises(
        NotReproduced,
        match=r"\(sha256 [0-9a-f]{12} instead of [0-9a-f]{12}\): although model, software, processor and mathematical",
    ):
        reproduction.check()
    for changes, words in (
        ({"dcrb_ros": "0.0.1"}, f"it was made by dcrb_ros 0.0.1 with model {model_fingerprint()}, this is {__version__} with model"),
        ({"model": "other"}, f"it was made by dcrb_ros {__version__} with model other, this is {__version__} with model"),
        ({"software": {**software(), "numpy": "1.0"}}, f"it was made with numpy 1.0 instead of {software()['numpy']}"),
        ({"software": {**software(), "libm": "glibc 2.31 (results 0)"}}, "it was made with libm glibc 2.31 (results 0) instead of glibc"),
        ({"software": {}}, f"it was made with python unknown instead of {software()['python']}, numpy unknown instead of"),
    ):
        recording.manifest.clear()
        recording.manifest.update(known | changes)
        assert reproduction.difference().startswith(words)
        with pytest.raises(NotReproduced, match="it was made"):
            reproduction.check()


def test_a_recording_older_than_the_record_of_the_functions_is_silent_about_them(tmp_path: Path) -> None:
    recording = Recording(recorded(tmp_path / "bag", 1))
    reproduction = Reproduction(recording)
    recording.manifest["software"] = {name: version for name, version in software().items() if name not in FUNCTIONS}
    assert reproduction.difference() == ""


WITH = {"target": "znver4", "features": ["fma", "avx2"]}
WITHOUT = {"target": "sandybridge", "features": ["avx"]}


def test_a_processor_without_fused_multiply_add_is_named_as_the_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recording = Recording(recorded(tmp_path / "bag", 1))
    reproduction = Reproduction(recording)
    monkeypatch.setattr("dcrb_ros.recordings.reproduction.processor", lambda: WITHOUT)
    recording.manifest["processor"] = WITH
    with pytest.raises(
        NotReproduced, match=r"compiled with fused multiply-add, for znver4 \(fma, avx2\), and the present ones without it, for sandy"
    ):
        reproduction.check()
    recording.manifest["software"] = {**software(), "numpy": "1.0"}
    assert "it was made with numpy 1.0" in reproduction.difference()
    assert "fused multiply-add" in reproduction.difference()


LAST = 1024 * 59
"""First sample of the last block of a recording of 60 blocks."""


@pytest.mark.parametrize(
    ("first", "samples", "end", "accepted"),
    [
        (0, 60 * 1024, LAST + 1024, True),
        (0, 9, LAST + (1 << 20), True),
        (0, 9, LAST + (1 << 20) + 1, False),
        (0, 9, 10**15, False),
        (-1, 9, 1000, False),
        (0, 1001, 1000, False),
    ],
)
def test_an_outcome_that_the_messages_contradict_is_refused(first: int, samples: int, end: int, accepted: bool, tmp_path: Path) -> None:
    recording = Recording(recorded(tmp_path / "bag", 60))
    recording.__dict__["outcome"] = {"first_index": first, "samples": samples, "end_index": end, "sha256": "0"}
    if accepted:
        assert recorded_samples(recording) == RecordedSamples(first, samples, "0", end)
    else:
        with pytest.raises(Refusal, match=f"states {samples} samples from {first} to {end}, but its last message belongs to sample {LAST}"):
            recorded_samples(recording)

"""A recording as arrays and frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dcrb_ros import Diagnosis, Recording, Refusal, load_configuration, simulate
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.simulation.loop import Simulation

BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("recording") / "bag"
    configuration = load_configuration("inner_ring_defect", {"publishing.contacts": True})
    simulation = Simulation(configuration)
    with Recorder(path, configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(0.4):
            recorder.write(block)
    return Recording(path)


def test_a_recording_gives_the_samples_of_the_run(recording: Recording) -> None:
    run, waveform = simulate(recording.configuration, 0.4), recording.waveform()
    assert np.array_equal(waveform.acceleration, run.acceleration)
    assert np.array_equal(waveform.shaft_angle, run.shaft_angle)
    assert np.array_equal(waveform.index, run.index)
    assert (waveform.orders, waveform.sampling_rate, waveform.sensor_range) == (run.orders, run.sampling_rate, run.sensor_range)
    assert recording.to_pandas().equals(run.to_pandas()[["ax", "ay", "shaft_angle"]])


def test_a_stretch_of_a_recording(recording: Recording) -> None:
    whole, part = recording.waveform(), recording.waveform(0.15, 0.25)
    assert np.array_equal(part.acceleration, whole.between(0.15, 0.25).acceleration)
    assert part.time[0] == pytest.approx(0.15, abs=1.0 / 51200)
    assert len(part) == 5120


def test_states_and_contacts_are_those_of_the_run(recording: Recording) -> None:
    run, states = simulate(recording.configuration, 0.4), recording.states()
    assert states.names == run.states.names
    for name in ("time", "azimuth", "speed", "inner_force", "outer_force", "slip", "friction"):
        assert getattr(states, name) == pytest.approx(getattr(run.states, name)), name
    assert states.torque is None
    assert states.to_pandas()["slip"].shape == states.azimuth.shape


def test_contacts_are_none_where_they_were_not_recorded() -> None:
    states = Recording(BAGS / "healthy").states()
    assert states.azimuth.shape == (299, 35)
    assert states.outer_force is None
    assert "slip" not in states.to_pandas().columns.get_level_values("quantity")


def test_truth_is_that_of_the_run(recording: Recording) -> None:
    run, truth = simulate(recording.configuration, 0.4), recording.truth()
    assert truth.time == pytest.approx(run.truth.time)
    assert truth.speed == pytest.approx(run.truth.speed)
    assert truth.faults["inner_1"] == pytest.approx(run.truth.faults["inner_1"])


def test_recorded_verdicts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recording: Recording) -> None:
    assert recording.verdicts() == []
    diagnosis = Diagnosis(51199, 51199 / 51200, "outer_ring", "BPFO stands out", confidence=0.875)
    message = diagnosis_messages(diagnosis)[0]
    monkeypatch.setattr(recording, "messages", lambda topics: iter([message]))
    (verdict,) = recording.verdicts()
    assert (verdict.verdict, verdict.confidence, verdict.reason) == ("outer_ring", 0.875, "BPFO stands out")
    assert verdict.time == pytest.approx(diagnosis.time, abs=1e-9)
    assert repr(verdict) == "<RecordedVerdict: outer_ring at 1.00 s>"


def test_representation_says_duration_rate_and_fault(recording: Recording) -> None:
    assert repr(recording).endswith("bag: 0.4 s at 51.2 kHz, 125.664 rad/s (1200 rpm), 100 kN, inner_1: 2 mm wide>")


def test_a_time_outside_the_recording_is_refused(recording: Recording) -> None:
    with pytest.raises(Refusal, match=r"bag has no sample from 3 to 4 s: it has samples from 0 to 0.4 s"):
        recording.waveform(3.0, 4.0)


def test_a_stretch_of_a_tenth_of_a_second_has_its_samples() -> None:
    recording = Recording(BAGS / "healthy")
    assert len(recording.waveform(1.1, 1.2)) == 5120
    assert recording.waveform(1.1).index[0] == 56320


def test_a_recording_has_what_the_result_of_a_simulation_has(recording: Recording) -> None:
    run = simulate(recording.configuration, 0.4)
    names = {name for name in dir(run) if not name.startswith("_")} - {"clean", "from_arrays"}
    assert names <= set(dir(recording))
    for name in ("acceleration", "shaft_angle", "index", "time", "turns"):
        assert np.array_equal(getattr(recording, name), getattr(run, name)), name
    for name in ("sampling_rate", "orders", "sensor_range", "duration", "tracked", "shaft_frequency", "configuration"):
        assert getattr(recording, name) == getattr(run, name), name
    assert np.array_equal(recording.between(0.1, 0.2).acceleration, run.between(0.1, 0.2).acceleration)
    for name in ("states", "truth", "temperatures", "tacho"):
        for signal in (recording, run):
            assert getattr(signal, name)() is getattr(signal, name)
        assert len(getattr(recording, name)) == len(getattr(run, name)) or name == "states"
    assert recording.states.azimuth.shape[1] == run.states.azimuth.shape[1]

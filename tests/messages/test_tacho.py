"""Pulses of a tacho on their topic and in recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_blocks import blocks

import dcrb_ros
from dcrb_ros.messages.description import decode_pulses_per_turn, sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.pulses import NUMBERS, decode_pulses, encode_pulses
from dcrb_ros.messages.topics import TACHO, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation

BAGS = Path(__file__).parents[2] / "bags"
WITH_TACHO = {"tacho.pulses_per_turn": 60}


@given(st.integers(0, 10**6), st.lists(st.integers(0, 20_000_000), max_size=60, unique=True), st.integers(0, 2 * NUMBERS))
def test_pulses_pass_through_a_message(index: int, offsets: list[int], first: int) -> None:
    block = replace(next(blocks(1)), index=index)
    times, numbers = block.stamp_ns + np.array(sorted(offsets), np.int64), first + np.arange(len(offsets))
    found = decode_pulses(encode_pulses(replace(block, pulse_ns=times, pulse_number=numbers)))
    assert found.stamp_ns == block.stamp_ns
    assert found.time_ns.tolist() == times.tolist()
    assert found.number.tolist() == [number % NUMBERS for number in numbers.tolist()]


def test_a_message_of_another_kind_or_length_is_refused() -> None:
    block = replace(next(blocks(1)), pulse_ns=np.array([5, 9]), pulse_number=np.array([0, 1]))
    with pytest.raises(Refusal, match=r"the fields \['t', 'ax', 'ay', 'shaft_angle'\] has no pulses of a tacho"):
        decode_pulses(encode_vibration(block, block.acceleration))
    data = bytearray(encode_pulses(block))
    width = data.index((2).to_bytes(4, "little"), 20)
    data[width] = 3
    with pytest.raises(Refusal, match="declares 3 pulses in 16 bytes"):
        decode_pulses(bytes(data))


def test_a_recording_has_the_pulses_of_each_block(tmp_path: Path) -> None:
    configuration = dcrb_ros.load_configuration("dry", WITH_TACHO)
    simulation = Simulation(configuration)
    made = list(simulation.blocks(0.1))
    with Recorder(tmp_path / "bag", configuration, simulation.bodies) as recorder:
        for block in made:
            recorder.write(block)
    recording = Recording(tmp_path / "bag")
    stamps = [[message.time_ns for message in recording.messages((topic,))] for topic in (TACHO, VIBRATION)]
    assert stamps[0] == stamps[1]
    tacho, run = recording.tacho(), dcrb_ros.simulate(configuration, 0.1).tacho
    assert recording.pulses_per_turn == tacho.pulses_per_turn == 60
    assert tacho.time.tolist() == run.time.tolist() == [time * 1e-9 for block in made for time in block.pulse_ns.tolist()]
    assert tacho.number.tolist() == run.number.tolist() == list(range(len(tacho)))
    frame = tacho.to_pandas()
    assert list(frame.columns) == ["pulse", "speed"]
    assert frame["speed"].iloc[1:].to_numpy() == pytest.approx(125.664, rel=1e-4)


def test_older_recordings_and_benches_without_a_tacho_have_none() -> None:
    recording = Recording(BAGS / "healthy")
    assert len(recording.tacho()) == len(recording.tacho().turns([])) == 0
    assert recording.configuration.tacho.pulses_per_turn == recording.pulses_per_turn == 0
    configuration = dcrb_ros.load_configuration("dry")
    assert not TACHO.enabled(configuration)
    assert "tacho" not in sensor_text(configuration)
    assert repr(recording.tacho()) == "<TachoPulses: 0 pulses, 0 per turn>"


def test_the_description_of_the_sensor_has_the_pulses_per_turn() -> None:
    assert decode_pulses_per_turn(encode_text(sensor_text(dcrb_ros.load_configuration("dry", WITH_TACHO)))) == 60
    assert decode_pulses_per_turn(encode_text('{"tacho_pulses_per_turn": "many"}')) == 0

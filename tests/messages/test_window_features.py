"""The topic of the features of windows: the same numbers online and offline, off by default."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dcrb_ros import extract_features
from dcrb_ros.bearing.payload import body_names
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import SIMULATED, Message
from dcrb_ros.messages.topics.window_features import WINDOW_FEATURES
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import waveform_of
from dcrb_ros.stream.block import Block

RATE = 12800


def sent(blocks: list[Block], *settings: str) -> list[Message]:
    """Return the messages of blocks on the topic."""
    configuration = load_configuration("dry", [f"sensor.sampling_rate={RATE}", *settings])
    encoder = BlockEncoder(configuration, body_names(configuration))
    return [message for block in blocks for message in encoder.encode(block) if message.topic is WINDOW_FEATURES]


def made_up(seconds: float, size: int, *, lost: int = -1) -> list[Block]:
    """Return blocks of noise at 20 Hz of the shaft, one of them lost."""
    samples = round(seconds * RATE)
    noise = np.random.default_rng(1).standard_normal((samples, 2)).astype(np.float32)
    angle = np.mod(2.0 * np.pi * 20.0 * np.arange(samples) / RATE, 2.0 * np.pi).astype(np.float32)
    begins = range(0, samples, size)
    return [
        Block(at, RATE, noise[at : at + size], angle[at : at + size], noise[at : at + size], lost=k == lost) for k, at in enumerate(begins)
    ]


def test_the_topic_is_off_unless_asked_for() -> None:
    assert WINDOW_FEATURES in SIMULATED
    assert sent(made_up(1.5, 1024)) == []


@pytest.mark.parametrize("size", [1000, 1024, 5000])
def test_messages_have_the_bits_of_extract_features_for_any_block_size(size: int) -> None:
    blocks = made_up(2.0, size)
    messages = sent(blocks, "publishing.features=true")
    table = extract_features(waveform_of(blocks, load_configuration("dry", [f"sensor.sampling_rate={RATE}"])))
    assert len(messages) == len(table) == 3
    for message, end, values in zip(messages, table.time, table.values, strict=True):
        assert message.content.names == table.names
        assert message.content.position.tobytes() == values.tobytes()
        assert message.time_ns == message.content.stamp_ns == round(end * 1e9)


def test_a_window_does_not_reach_across_a_lost_block() -> None:
    messages = sent(made_up(2.2, 1024, lost=4), "publishing.features=true")
    assert [message.time_ns for message in messages] == [round((5 * 1024 / RATE + 1.0 + 0.5 * k) * 1e9) for k in range(2)]


def test_a_recording_holds_what_its_waveform_gives(tmp_path: Path) -> None:
    configuration = load_configuration("dry", [f"sensor.sampling_rate={RATE}", "cage.joint=revolute", "publishing.features=true"])
    simulation = Simulation(configuration)
    with Recorder(tmp_path / "run", configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(1.5):
            recorder.write(block)
    recording = Recording(tmp_path / "run")
    table = extract_features(recording)
    recorded = [message.content for message in recording.messages([WINDOW_FEATURES])]
    assert np.array([one.position for one in recorded]).tobytes() == table.values.tobytes()
    assert recorded[0].names == table.names

"""Blocks that do not arrive: lost at random, or between two bursts; what recordings and the ground truth say of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import ACCELERATION, FEATURES, GROUND_TRUTH, ROLLER_STATES, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.reproduction import Reproduction
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.transmission import Transmission
from dcrb_ros.stream.events import BlockLost


def bench(**publishing: float) -> Configuration:
    return Configuration.model_validate({"cage": {"joint": "revolute"}, "publishing": {"block_size": 512, **publishing}})


def test_blocks_are_lost_by_the_seed() -> None:
    def lost(seed: int) -> list[bool]:
        groups = {"simulation": {"seed": seed}, "publishing": {"loss_probability": 0.3}}
        transmission = Transmission(Configuration.model_validate(groups))
        return [transmission.next_is_lost() for _ in range(2000)]

    assert lost(1) == lost(1)
    assert abs(np.mean(lost(1)) - 0.3) < 0.04
    assert lost(1) != lost(2)


def test_a_lost_block_is_told_and_the_run_makes_itself_again(tmp_path: Path) -> None:
    configuration = bench(loss_probability=0.3)
    simulation = Simulation(configuration)
    blocks = list(simulation.blocks(0.2))
    with Recorder(tmp_path / "lossy", configuration, simulation.bodies) as recorder:
        for block in blocks:
            recorder.write(block)
    recording = Recording(tmp_path / "lossy")
    kept = [vibration.first_index(51200) for vibration in recording.vibrations()]
    assert kept == [block.index for block in blocks if not block.lost]
    assert 0 < len(kept) < len(blocks)
    events = [decode_truth(message.data).event for message in recording.messages((GROUND_TRUTH,))]
    lost = [BlockLost(block.index, block.index + len(block.shaft_angle) - 1) for block in blocks if block.lost]
    assert [event for event in events if isinstance(event, BlockLost)] == lost
    assert recording.commands() == []
    reproduction = Reproduction(recording)
    for _ in reproduction.blocks(Simulation(reproduction.configuration)):
        pass
    reproduction.check()


def test_bursts_leave_out_what_is_made_of_samples() -> None:
    configuration = bench(burst_length=0.02, burst_period=0.05)
    simulation = Simulation(configuration)
    encoder = BlockEncoder(configuration, simulation.bodies)
    published = []
    for block in simulation.blocks(0.15):
        topics = {message.topic for message in encoder.encode(block)}
        assert (FEATURES in topics, VIBRATION in topics) == (not block.lost, not block.lost)
        assert not (block.lost and ACCELERATION in topics)
        assert ROLLER_STATES in topics or not block.states
        published += [] if block.lost else [block.index]
    assert published == [2560 * period + 512 * k for period in range(3) for k in range(2)]

"""The shipped recordings equal what the present code simulates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.verification import metadata_flaw
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.event_text import encode_event
from dcrb_ros.stream.events import SpeedCommand, Start, TimedCommand

BEFORE_CHAOS = 0.01
"""[s]."""
BAGS = sorted(path.parent for path in (Path(__file__).parents[2] / "bags").glob("*/metadata.yaml"))


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_shipped_recordings_are_complete_and_small(bag: Path) -> None:
    recording = Recording(bag)
    assert recording.counts()["/dcrb/outer_ring/vibration"] == 150
    assert recording.complete
    assert metadata_flaw(bag) == ""
    assert sum(file.stat().st_size for file in bag.iterdir()) < 3e6


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_events_are_recovered_from_the_shipped_recordings(bag: Path) -> None:
    recording = Recording(bag)
    messages = [message.data for message in recording.messages((GROUND_TRUTH,))]
    truths = [decode_truth(data) for data in messages]
    assert [encode_event(truth.event) for truth in truths] == [decode_diagnostics(data)[1][0].message for data in messages]
    command = SpeedCommand(150.0)
    commanded = [TimedCommand(500_253_906, command)] if bag.name == "run_up" else []
    assert [truth.event for truth in truths if truth.event] == [Start(), *(timed.command for timed in commanded)]
    assert recording.commands() == commanded  # of the manifest
    recording.__dict__["outcome"] = None
    assert recording.commands() == commanded  # of the ground truth


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_shipped_recordings_agree_with_the_present_model(bag: Path) -> None:
    # Before the motion of unloaded rollers becomes chaotic, a difference in the last bit, from another library for instance, is small.
    recording = Recording(bag)
    simulation = Simulation(recording.configuration)
    made = np.concatenate([block.acceleration for block in simulation.blocks(BEFORE_CHAOS)])
    kept = next(iter(recording.vibrations())).acceleration[: len(made)]
    assert np.abs(made - kept).max() < 1e-3 * np.abs(kept).max(), "the model has changed: see bags/README.md"

"""The speed from the pulses of a tacho, and temperatures, in the viewer: recorded and live."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun_documents import rows
from runs import record

import dcrb_ros
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import TACHO
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.viewer.live import LiveView
from dcrb_ros.viewer.reader import read_content, tacho_of
from dcrb_ros.viewer.summary import markdown

WARM = {"thermal.law": "network", "tacho.pulses_per_turn": 60}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    configuration = dcrb_ros.load_configuration("healthy", WARM)
    return record(tmp_path_factory.mktemp("warm") / "bag", configuration, Simulation(configuration).blocks(0.3))


def test_a_recording_shows_the_speed_between_pulses_and_the_temperatures(bag: Path) -> None:
    content = read_content(Recording(bag))
    assert content.tacho is not None
    assert len(content.tacho.time_ns) == len(Recording(bag).tacho()) - 1
    assert content.tacho.values == pytest.approx(125.66, rel=0.01)
    page = markdown(content, content.truths[-1])
    warmest = max(value for name, value in content.truths[-1].thermal.items() if name.endswith("inner_ring [deg C]"))
    assert f"| Temperatures | inner ring {warmest:.1f}, rollers " in page
    assert "ambient 20.0 °C |" in page


def running(simulation: Simulation, duration: float, file: Path, batch: int = 1000) -> tuple[Counter[str], list[Block]]:
    """Return what is shown of a running bench, in batches of some blocks, and its blocks."""

    def begin(_: int) -> rr.RecordingStream:
        stream = rr.RecordingStream("dcrb")
        stream.save(file)
        return stream

    warnings, blocks = list[str](), list(simulation.blocks(duration))
    encoder, view = BlockEncoder(simulation.configuration, simulation.bodies), LiveView(begin, "/dcrb", warnings.append)
    for message in encoder.start():
        view.take(message.topic, message.data)
    for number, block in enumerate(blocks, 1):
        for message in encoder.encode(block):
            view.take(message.topic, message.data)
        if number % batch == 0:
            view.flush()
    view.close()
    assert warnings == []
    return rows(file), blocks


def test_a_running_bench_shows_them_too(tmp_path: Path) -> None:
    found, blocks = running(Simulation(dcrb_ros.load_configuration("healthy", WARM)), 0.2, tmp_path / "live.rrd")
    assert found["/operating/tacho"] == sum(len(block.pulse_ns) for block in blocks) - 1
    assert found["/temperatures"] == 2  # at 0 and 0.1 s


@pytest.mark.parametrize(("pulses_per_turn", "batch"), [(1, 1), (1, 2), (60, 1)])
def test_a_running_bench_shows_every_speed_once_also_with_less_than_two_pulses_in_a_batch(
    pulses_per_turn: int, batch: int, tmp_path: Path
) -> None:
    simulation = Simulation(dcrb_ros.load_configuration("dry", {"tacho.pulses_per_turn": pulses_per_turn}))
    shown, blocks = running(simulation, 0.4, tmp_path / "live.rrd", batch)
    assert shown["/operating/tacho"] == sum(len(block.pulse_ns) for block in blocks) - 1


def test_pulses_without_their_number_per_turn_have_no_speed() -> None:
    assert tacho_of([], 60) is None
    simulation = Simulation(dcrb_ros.load_configuration("dry", {"tacho.pulses_per_turn": 60}))
    encoder = BlockEncoder(simulation.configuration, simulation.bodies)
    data = [message.data for message in encoder.encode(next(simulation.blocks())) if message.topic == TACHO]
    assert tacho_of(data, 0) is None
    found = tacho_of(data, 60)
    assert found is not None
    assert np.diff(found.time_ns).min() > 0

"""The speed from the pulses of a tacho, and temperatures, in the viewer: recorded and live."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun_documents import rows

import dcrb_ros
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import TACHO
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.viewer.live import LiveView
from dcrb_ros.viewer.reader import read_content, tacho_of
from dcrb_ros.viewer.summary import markdown

WARM = {"thermal.law": "network", "tacho.pulses_per_turn": 60}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path, simulation = tmp_path_factory.mktemp("warm") / "bag", Simulation(dcrb_ros.load_configuration("healthy", WARM))
    with Recorder(path, simulation.configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(0.3):
            recorder.write(block)
    return path


def test_a_recording_shows_the_speed_between_pulses_and_the_temperatures(bag: Path) -> None:
    content = read_content(Recording(bag))
    assert content.tacho is not None
    assert len(content.tacho.time_ns) == len(Recording(bag).tacho()) - 1
    assert content.tacho.values == pytest.approx(125.66, rel=0.01)
    page = markdown(content, content.truths[-1])
    warmest = max(value for name, value in content.truths[-1].thermal.items() if name.endswith("inner_ring [deg C]"))
    assert f"| Temperatures | inner ring {warmest:.1f}, rollers " in page
    assert "ambient 20.0 °C |" in page


def test_a_running_bench_shows_them_too(tmp_path: Path) -> None:
    def begin(_: int) -> rr.RecordingStream:
        stream = rr.RecordingStream("dcrb")
        stream.save(tmp_path / "live.rrd")
        return stream

    simulation, warnings = Simulation(dcrb_ros.load_configuration("healthy", WARM)), list[str]()
    encoder, view = BlockEncoder(simulation.configuration, simulation.bodies), LiveView(begin, "/dcrb", warnings.append)
    blocks = list(simulation.blocks(0.2))
    for message in [*encoder.start(), *(message for block in blocks for message in encoder.encode(block))]:
        view.take(message.topic, message.data)
    view.close()
    assert warnings == []
    found = rows(tmp_path / "live.rrd")
    assert found["/operating/tacho"] == sum(len(block.pulse_ns) for block in blocks) - 1
    assert found["/temperatures"] == 2  # at 0 and 0.1 s


def test_pulses_without_their_number_per_turn_have_no_speed() -> None:
    assert tacho_of([], 60) is None
    simulation = Simulation(dcrb_ros.load_configuration("dry", {"tacho.pulses_per_turn": 60}))
    encoder = BlockEncoder(simulation.configuration, simulation.bodies)
    data = [message.data for message in encoder.encode(next(simulation.blocks())) if message.topic == TACHO]
    assert tacho_of(data, 0) is None
    found = tacho_of(data, 60)
    assert found is not None
    assert np.diff(found.time_ns).min() > 0

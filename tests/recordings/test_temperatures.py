"""The readings of temperature in a run and in its recording, and what the detector makes of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dcrb_ros
from dcrb_ros import TemperatureReadings
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import SimulationResult

DURATION = 1.6
"""[s]"""


@pytest.fixture(scope="module")
def run() -> SimulationResult:
    return dcrb_ros.simulate("healthy", DURATION, settings={"thermal.law": "network"})


@pytest.mark.slow
def test_a_recording_has_the_readings_of_its_run(run: SimulationResult, tmp_path: Path) -> None:
    simulation = Simulation(run.configuration)
    with Recorder(tmp_path / "warm", run.configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(DURATION):
            recorder.write(block)
    found = Recording(tmp_path / "warm").temperatures()
    assert found.time.tolist() == [0.0, 1.0]
    assert found.to_pandas().equals(run.temperatures.to_pandas())


def test_the_detector_uses_the_readings_of_a_run(run: SimulationResult) -> None:
    assert any("K above ambient" in remark for remark in dcrb_ros.detect(run).last.remarks)
    assert not any("K above ambient" in remark for remark in dcrb_ros.detect(run, temperatures=TemperatureReadings.none()).last.remarks)


def test_a_recording_without_a_network_has_none() -> None:
    assert Recording(Path(__file__).parents[2] / "bags" / "healthy").temperatures().time.tolist() == []


def test_the_box_stands_in_for_an_outer_ring_that_was_not_measured() -> None:
    unknown, known = np.full(2, np.nan), np.array([40.0, 41.0])
    feed = TemperatureFeed(TemperatureReadings(time=np.array([0.0, 1.0]), outer_ring=unknown, box=known, ambient=np.array([20.0, np.nan])))
    taken: list[tuple[float, ...]] = []
    feed.give(lambda *reading: taken.append(reading), 0.5)
    assert taken == [(0.0, 40.0, 20.0)]
    feed.give(lambda *reading: taken.append(reading), 5.0)
    assert len(taken) == 1, "a reading without the air is left out"

"""The readings of temperature in a run and in its recording, and what the detector makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

import dcrb_ros
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import Run

WARM = {"thermal.law": "network", "lubrication.law": "film"}
DURATION = 1.6
"""[s]"""


@pytest.fixture(scope="module")
def run() -> Run:
    return dcrb_ros.simulate("healthy", DURATION, settings=WARM)


def test_a_recording_has_the_readings_of_its_run(run: Run, tmp_path: Path) -> None:
    simulation = Simulation(run.configuration)
    with Recorder(tmp_path / "warm", run.configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(DURATION):
            recorder.write(block)
    found = Recording(tmp_path / "warm").temperatures()
    assert [one.time_ns for one in found] == [0, 1_000_000_000]
    assert tuple(found) == run.temperatures


def test_the_detector_uses_the_readings_of_a_run(run: Run) -> None:
    assert any("K above ambient" in remark for remark in dcrb_ros.detect(run).last.remarks)
    assert not any("K above ambient" in remark for remark in dcrb_ros.detect(run, temperatures=()).last.remarks)


def test_a_recording_without_a_network_has_none() -> None:
    assert Recording(Path(__file__).parents[2] / "bags" / "healthy").temperatures() == []

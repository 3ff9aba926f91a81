"""Gravity in the samples of sensors that measure constant acceleration."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import as_recorded
from dcrb_ros.simulation.loop import Simulation

REST = {"operating": {"speed": 0.0}, "simulation": {"seed": 4}}


def mean(**sensor: object) -> np.ndarray:
    """Return the mean acceleration of a standing bearing in X and Y [m/s^2]."""
    blocks = Simulation(Configuration.model_validate({**REST, "sensor": sensor})).blocks(0.3)
    return np.asarray(np.concatenate([block.acceleration for block in blocks])[5120:].mean(axis=0))


def test_a_mems_sensor_at_rest_reads_gravity_upwards() -> None:
    assert mean(preset="mems", bias=0.0, bias_drift=0.0, cross_axis=0.0) == pytest.approx([0.0, 9.80665], abs=0.02)


def test_cross_axis_sensitivity_turns_gravity_into_the_other_axis() -> None:
    assert mean(preset="mems", bias=0.0, bias_drift=0.0)[0] == pytest.approx(0.01 * 9.80665, abs=0.02)


@pytest.mark.parametrize("preset", ["none", "ideal", "iepe_100mv_g"])
def test_the_other_presets_read_changes_only(preset: str) -> None:
    assert mean(preset=preset)[1] == pytest.approx(0.0, abs=0.05)


def test_an_older_recording_keeps_the_preset_of_its_time() -> None:
    """A manifest names every parameter of its time; the preset must not add what came later."""
    written = Configuration.model_validate({"sensor": {"preset": "mems"}}).model_dump()
    del written["sensor"]["static_gravity"]
    assert Configuration.model_validate(as_recorded(written)).sensor.static_gravity == 0.0
    now = Configuration.model_validate({"sensor": {"preset": "mems"}})
    assert Configuration.model_validate(as_recorded(now.model_dump())) == now

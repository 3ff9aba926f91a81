"""Machines that a calibration draws."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dcrb_ros import Refusal, load_configuration
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.calibration.calibration import Calibration, accepted
from dcrb_ros.calibration.estimate import EstimatedParameter, PathLevel
from dcrb_ros.calibration.files import vary


def calibration() -> Calibration:
    """Return a calibration whose path deviates by 2 dB."""
    configuration = load_configuration("healthy", {"structure.housing": "none", "structure.path_y": "1400 0.03 1600 0.05"})
    measured = Waveform.__new__(Waveform)
    level = PathLevel("y", 1000.0, 3.0, 1.0, 5.0, 0.9, chance=2.0)
    return Calibration(configuration, (), {}, (level,), (), (), measured, (("y", np.zeros(1), np.zeros(1)),))


def test_drawn_machines_differ_by_the_spread_of_the_path() -> None:
    found = calibration()
    drawn = found.draw(3)
    assert drawn["structure.path_spread"] == 2.0
    assert load_configuration(found.configuration, drawn).structure.seed == drawn["structure.seed"]
    assert vary(found)["structure.path_spread"] == {"low": 0.0, "high": 2.0}


@pytest.mark.parametrize(("other", "varied"), [(125.6640001, False), (125.67, True)])
def test_an_interval_that_vanishes_by_rounding_is_no_axis(other: float, varied: bool) -> None:
    # Recordings at 125.664 rad/s whose angles are rounded: a sweep refuses a range from 125.664 to 125.664.
    speed = EstimatedParameter("operating.speed", 125.664, 125.664, other, "rad/s")
    axes = vary(replace(calibration(), estimates=(speed,)))
    assert ("operating.speed" in axes) is varied
    assert all(axis["low"] < axis["high"] for axis in axes.values())


def test_an_interval_ends_at_the_range_of_its_parameter() -> None:
    wide = EstimatedParameter("background.hum_level", 900.0, 700.0, 1100.0, "m/s^2")
    assert accepted([wide], load_configuration("healthy")) == ([replace(wide, high=1000.0)], [])


def test_an_interval_that_the_bench_does_not_accept_is_stated() -> None:
    low = EstimatedParameter("friction.static_coefficient", 0.1, 1e-3, 0.2, "-")
    kept, (sentence,) = accepted([low], load_configuration("healthy"))
    assert kept == []
    assert sentence.startswith("friction.static_coefficient has no interval, 0.001 to 0.2: friction.static_coefficient = 0.001 is below")


@pytest.mark.parametrize("seed", [-1, 1.0, True, "3", None])
def test_a_machine_has_a_whole_number(seed: Any) -> None:
    with pytest.raises(Refusal, match="is not a whole number from 0 on"):
        calibration().draw(seed)
    assert calibration().draw(int(np.int64(3))) == calibration().draw(3)

"""Lines of gears and motor: their orders, amplitudes and sidebands."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from chain import SPEED, amplitude, at_rest, chain
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.traction_drive import TractionDrive

RELATIVE_SPEED = SPEED * 0.46 / 20.0
"""Vehicle speed relative to the one at which levels are given [-]."""
TURN = SPEED / (2.0 * np.pi)
"""Revolutions of the shaft per second at that speed [Hz], 20 within 1e-5."""


def found(background: dict[str, float], speed: float = SPEED) -> np.ndarray:
    """Return a second of the background of a ring at rest, shape (51200, 2) [m/s^2]."""
    return at_rest(chain(background=background), 1.1, speed).measured[2560 : 2560 + 51200]


def test_gears_have_three_mesh_harmonics_with_sidebands_at_the_shaft_speed() -> None:
    signal = found({"gear_level": 4.0, "gear_teeth": 50, "gear_modulation": 0.3})[:, 0] / RELATIVE_SPEED
    orders = (50, 100, 150, 200, 49, 51, 48, 1)
    levels = [amplitude(signal, k * TURN, 51200.0) for k in orders]
    assert levels == pytest.approx([4.0, 2.0, 1.0, 0.0, 0.6, 0.6, 0.0, 0.0], abs=0.02)


def test_the_motor_has_lines_at_its_speed_and_at_twice_its_supply_frequency() -> None:
    signal = found({"motor_level": 3.0, "motor_ratio": 4.5, "motor_pole_pairs": 2})[:, 1] / RELATIVE_SPEED
    levels = [amplitude(signal, k * TURN, 51200.0) for k in (18.0, 4.5, 9.0, 1.0)]
    assert levels == pytest.approx([3.0, 1.5, 0.0, 0.0], abs=0.02)


def test_the_level_is_proportional_to_the_speed_and_independent_of_its_direction() -> None:
    drive = {"gear_level": 2.0, "motor_level": 1.0}
    full, half, back = (found(drive, speed).std() for speed in (SPEED, 0.5 * SPEED, -SPEED))
    assert half == pytest.approx(0.5 * full, rel=1e-2)
    assert back == pytest.approx(full, rel=1e-3)
    assert not found(drive, 0.0).any()


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6), st.integers(0, 2**31 - 1))
def test_samples_do_not_depend_on_how_they_are_split(lengths: list[int], seed: int) -> None:
    configuration = chain(background={"gear_level": 2.0, "motor_level": 1.0}, simulation={"seed": seed})
    setup, count = configuration.measurement, sum(lengths)
    angle = SPEED * np.arange(count + 1) / configuration.step_rate
    stage = TractionDrive(setup, float(configuration.step_rate))
    stage.set_parameters(setup.parameters, 0)
    whole = stage.process(np.zeros((count, 2)), Span(0, angle))
    edges = np.cumsum([0, *lengths])
    parts = [stage.process(np.zeros((b - a, 2)), Span(a, angle[a : b + 1])) for a, b in itertools.pairwise(edges)]
    assert np.array_equal(np.concatenate(parts), whole)

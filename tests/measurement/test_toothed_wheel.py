"""Pulses of a toothed wheel: at the angles of its teeth, in any chunks, on the clock of the samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.toothed_wheel import ToothedWheel

RATE = 100_000
"""Time steps per second [Hz]."""


def test_pulses_are_at_the_beginnings_of_the_teeth() -> None:
    speed, teeth = 7.0, 30  # turns per second
    angle = 2.0 * np.pi * (speed * np.arange(RATE) / RATE + 0.01)
    found = ToothedWheel(teeth, RATE).pulses(angle)
    expected = (np.arange(1, 1 + len(found)) / teeth - 0.01) / speed
    assert len(found) == 210
    assert np.abs(found * 1e-9 - expected).max() < 0.6e-9  # whole nanoseconds


def test_a_wheel_that_begins_at_a_tooth_has_not_passed_it() -> None:
    assert ToothedWheel(1, RATE).pulses(np.linspace(0.0, 6.0, 100)).size == 0


def test_backwards_the_other_flank_of_a_tooth_makes_the_pulse() -> None:
    angle = 2.0 * np.pi * np.array([0.8, 0.74, 0.6, 0.45, 0.2])  # 2 teeth: from 0 to 0.25 and from 0.5 to 0.75
    found = ToothedWheel(2, RATE).pulses(angle)
    assert found.tolist() == pytest.approx([1e9 / RATE * (0.05 / 0.06), 1e9 / RATE * (3.0 + 0.2 / 0.25)], abs=1.0)


def test_a_shaft_that_rocks_about_a_flank_makes_a_pulse_each_time() -> None:
    angle = 0.3 * np.sin(np.linspace(-1.0, 8.0 * np.pi - 1.0, 1000))  # from below zero, four times up through it
    assert len(ToothedWheel(1, RATE).pulses(angle)) == 4


@given(st.lists(st.integers(1, 400), min_size=1, max_size=20))
def test_the_pulses_are_the_same_in_any_chunks(sizes: list[int]) -> None:
    time = np.arange(sum(sizes)) / RATE
    angle = 125.0 * time + 0.3 * np.sin(300.0 * time)
    whole, wheel = ToothedWheel(80, RATE).pulses(angle), ToothedWheel(80, RATE)
    parts = [wheel.pulses(part) for part in np.split(angle, np.cumsum(sizes)[:-1])]
    assert np.array_equal(np.concatenate(parts), whole)


def test_a_late_sample_clock_stamps_pulses_early() -> None:
    angle = 100.0 * np.arange(RATE) / RATE
    true, stamped = ToothedWheel(10, RATE).pulses(angle), ToothedWheel(10, RATE, 200.0).pulses(angle)
    assert np.abs(stamped - true / (1.0 + 200e-6)).max() <= 1.0

"""Pulses at exact times, against their closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.pulses import Passings, Pulses

RATE, DURATION = 1000.0, 0.0085
LENGTH = DURATION * RATE


def hann(at: float, peak: float, count: int) -> npt.NDArray[np.float64]:
    """Return a Hann pulse that starts at a time in steps."""
    share = (np.arange(count) - at) / LENGTH
    return np.where((share >= 0.0) & (share <= 1.0), peak * np.sin(math.pi * share) ** 2, 0.0)


@given(at=st.lists(st.floats(0.0, 60.0), max_size=5).map(sorted), cuts=st.lists(st.integers(0, 30), max_size=6))
def test_pulses_add_up_and_do_not_depend_on_the_split(at: list[float], cuts: list[int]) -> None:
    pulses, first, parts = Pulses(DURATION, RATE), 0, []
    for number, begin in enumerate(at):
        pulses.begin(begin, number + 1.0)
    for count in (*cuts, 80):
        parts.append(pulses.process(first, count))
        first += count
    due = sum((hann(begin, number + 1.0, first) for number, begin in enumerate(at)), np.zeros(first))
    assert np.concatenate(parts) == pytest.approx(due, abs=1e-12)


def test_a_pulse_at_a_whole_step_has_its_peak_in_the_middle() -> None:
    pulses = Pulses(0.008, RATE)
    pulses.begin(3.0, 5.0)
    found = pulses.process(0, 20)
    assert (found[7], found[3], found[11]) == (5.0, 0.0, 0.0)
    assert (found[:3] == 0.0).all()
    assert (found[12:] == 0.0).all()


def test_pulses_that_have_ended_are_forgotten() -> None:
    pulses = Pulses(0.008, RATE)
    for k in range(100):
        pulses.begin(float(k), 1.0)
        pulses.process(k, 1)
        assert len(pulses._present) <= 9


@pytest.mark.parametrize("speed", [0.013, -0.013, 0.3])
def test_a_pulse_starts_when_the_shaft_passes_the_phase(speed: float) -> None:
    """With a period of 0.7 rad and a phase of 0.25, the shaft passes at angles of 0.7 (k + 0.25)."""
    count = 200
    angle = speed * np.arange(-1.0, count)
    passings = Passings(0.7, 0.25, Pulses(DURATION, RATE))
    found = passings.process(0, angle, 2.0 + np.arange(count))
    due = np.zeros(count)
    for k in range(-100, 100):
        at = 0.7 * (k + 0.25) / speed
        if -1.0 < at <= count - 1.0:
            due += hann(at, 2.0 + math.ceil(at), count)  # the peak belongs to the step that ends after the passing
    assert due.max() > 0.0
    assert found == pytest.approx(due, abs=1e-9)


def test_a_shaft_at_rest_passes_nothing() -> None:
    assert not Passings(0.7, 0.0, Pulses(DURATION, RATE)).process(0, np.full(51, 0.7), np.ones(50)).any()

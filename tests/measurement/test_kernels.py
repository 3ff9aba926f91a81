"""Compiled loops over samples, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from dcrb_ros.measurement.kernels import decimated, filtered, interpolated
from dcrb_ros.measurement.sample_clock import interpolation_weights


@given(count=st.integers(0, 11), factor=st.integers(1, 5), first=st.integers(0, 3), taps=st.integers(1, 7))
def test_decimated_samples_are_sums_of_taps_times_samples(count: int, factor: int, first: int, taps: int) -> None:
    random = np.random.default_rng(count)
    known, weights = random.standard_normal((80, 2)), random.standard_normal(taps)
    found = decimated(weights, known, first, factor, count)
    expected = [weights @ known[first + k * factor : first + k * factor + taps] for k in range(count)]
    assert found == pytest.approx(np.array(expected).reshape(count, 2), abs=1e-12)


def test_filtered_samples_equal_those_of_scipy_in_each_column() -> None:
    sections = signal.butter(5, [0.1, 0.3], "bandpass", output="sos")
    samples = np.random.default_rng(1).standard_normal((300, 3))
    memory = np.zeros((len(sections), 2, 3))
    found = np.concatenate([filtered(sections, memory, samples[:100]), filtered(sections, memory, samples[100:])])
    assert found == pytest.approx(signal.sosfilt(sections, samples, axis=0), rel=1e-9, abs=1e-12)


def test_a_place_at_a_sample_gives_that_sample() -> None:
    """The place may be rounded to 1, that is to the next sample."""
    known = np.random.default_rng(1).standard_normal((60, 3))
    out = np.empty((2, 2))
    interpolated(known, np.array([30, 30]), np.array([0.0, 1.0]), interpolation_weights(), out)
    assert out == pytest.approx(known[30:32, :2], abs=1e-12)


@given(place=st.floats(0.0, 1.0))
def test_weights_are_interpolated_linearly_between_two_phases(place: float) -> None:
    known, weights = np.random.default_rng(1).standard_normal((9, 2)), np.random.default_rng(2).standard_normal((5, 4))
    out = np.empty((1, 2))
    interpolated(known, np.array([4]), np.array([place]), weights, out)
    between = [np.interp(4.0 * place, np.arange(5), column) for column in weights.T]
    assert out[0] == pytest.approx(np.array(between) @ known[3:7], abs=1e-9)

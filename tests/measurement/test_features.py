"""Statistical features, of signals whose values are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.measurement.features import features


def test_features_of_a_sine_in_the_vertical_axis() -> None:
    """A sine of amplitude A has an rms of A / sqrt(2) and a kurtosis of 3/2, whatever its mean."""
    sine = 6.0 * np.sin(2.0 * math.pi * np.arange(1000) / 40.0)
    found = features(np.column_stack([np.full(1000, 99.0), 2.5 + sine]), 7)
    expected = {"rms": 6.0 / math.sqrt(2.0), "peak": 6.0, "crest": math.sqrt(2.0), "kurtosis": 1.5, "clipped": 7.0}
    assert found == pytest.approx(expected)


def test_a_constant_signal_has_no_features() -> None:
    assert set(features(np.full((8, 2), 3.0), 0).values()) == {0.0}


def test_a_single_impact_has_a_large_kurtosis() -> None:
    """One sample of N that differs has a kurtosis of N - 2 + 1 / (N - 1) and a crest factor of sqrt(N - 1)."""
    samples = np.zeros((100, 2))
    samples[40, 1] = -5.0
    found = features(samples, 0)
    assert (found["kurtosis"], found["crest"]) == (pytest.approx(98.0 + 1.0 / 99.0), pytest.approx(math.sqrt(99.0)))

"""Resampling over the angle of the shaft."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.order_tracking import bin_edges, bin_means, reverses, unwrapped_turns

RATE = 51200
TIME = np.arange(2 * RATE) / RATE


@given(frequency=st.floats(4.0, 80.0), bins=st.integers(16, 256))
def test_resampling_preserves_a_constant(frequency: float, bins: int) -> None:
    turns = frequency * TIME
    edges = bin_edges(0.0, float(turns[-1]), bins)
    means = bin_means(np.arange(len(TIME), dtype=float), np.full(len(TIME), 7.0), np.interp(edges, turns, np.arange(len(TIME))))
    assert len(means) == pytest.approx(2.0 * frequency * bins, abs=2)
    np.testing.assert_allclose(means, 7.0, rtol=1e-9)


@given(frequency=st.floats(-60.0, 60.0))
def test_unwrapping_restores_the_turns(frequency: float) -> None:
    angle = np.mod(2.0 * math.pi * frequency * TIME[:5000], 2.0 * math.pi).astype(np.float32)
    np.testing.assert_allclose(unwrapped_turns(angle), frequency * TIME[:5000], atol=1e-5)


def test_reversal_is_distinguished_from_jitter() -> None:
    there_and_back = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.2, 50)])
    jitter = np.linspace(0.0, 1.0, 100) + 0.001 * np.random.default_rng(1).normal(size=100)
    assert reverses(there_and_back)
    assert not reverses(jitter)
    assert not reverses(-jitter)

"""Convolution with long impulse responses: exact, causal, the same bits for any block size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import oaconvolve

from dcrb_ros.measurement.convolution import Convolution
from dcrb_ros.schema.arrays import Floats


def response(taps: int) -> Floats:
    """Return decaying noise, shape (2, taps)."""
    return np.random.default_rng(taps).normal(size=(2, taps)) * np.exp(-np.arange(taps) / 900.0)


def in_blocks(taps: int, samples: Floats, sizes: list[int]) -> Floats:
    """Return samples after a convolution that receives them in blocks of repeated sizes."""
    convolution, parts, start, number = Convolution(response(taps)), [], 0, 0
    while start < len(samples):
        size = sizes[number % len(sizes)]
        parts.append(convolution.process(samples[start : start + size]))
        start, number = start + size, number + 1
    return np.concatenate(parts)


@pytest.mark.parametrize("taps", [1, 3, 255, 256, 257, 700, 5120, 10240])
def test_it_is_the_sum_of_products(taps: int) -> None:
    samples = np.random.default_rng(1).normal(size=(12000, 2))
    expected = np.stack([oaconvolve(samples[:, axis], response(taps)[axis])[: len(samples)] for axis in (0, 1)], axis=1)
    assert in_blocks(taps, samples, [len(samples)]) == pytest.approx(expected, rel=0.0, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("size", [1, 7, 255, 256, 2048])
def test_blocks_have_the_bits_of_the_whole(size: int) -> None:
    samples = np.random.default_rng(2).normal(size=(3000, 2))
    assert np.array_equal(in_blocks(2000, samples, [size]), in_blocks(2000, samples, [len(samples)]))


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(1, 900), min_size=1, max_size=8), st.sampled_from([1, 300, 1500]))
def test_no_split_changes_a_bit(sizes: list[int], taps: int) -> None:
    samples = np.random.default_rng(3).normal(size=(2500, 2))
    assert np.array_equal(in_blocks(taps, samples, sizes), in_blocks(taps, samples, [len(samples)]))


@pytest.mark.parametrize("at", [0, 100, 255, 256, 1000])
def test_nothing_comes_before_the_impulse(at: int) -> None:
    samples = np.zeros((4000, 2))
    samples[at] = 1.0
    found = in_blocks(1500, samples, [333])
    assert not found[:at].any()
    assert found[at : at + 1500] == pytest.approx(response(1500).T, abs=1e-14)

"""Noise that follows the spectrum of a signal: power, spectrum, Gaussian values without the period of the signal, and a change."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal, stats

from dcrb_ros.measurement.following_noise import FollowingNoise
from dcrb_ros.schema.arrays import Floats

RATE = 51200.0
PERIOD = 512


def ringing(seconds: float) -> Floats:
    """Return impacts 100 times a second that ring at 3 kHz, in both axes, half as strong in the second one."""
    ring = np.zeros((round(seconds * RATE), 2))
    ring[::PERIOD] = [1.0, 0.5]
    band: Floats = signal.sosfilt(signal.butter(1, [2.8e3, 3.2e3], "bandpass", fs=RATE, output="sos"), ring, axis=0)
    return band


def following(samples: Floats, seed: int = 1, smoothing: float = 0.5) -> Floats:
    """Return the noise beside samples."""
    return FollowingNoise(np.random.default_rng(seed), RATE, smoothing).process(samples)


def test_it_has_the_power_spectrum_of_the_signal_in_each_axis() -> None:
    samples = ringing(8.0)
    noise = following(samples)[round(RATE) :]
    assert (noise**2).mean(axis=0) == pytest.approx((samples**2).mean(axis=0), rel=0.05)
    for edges in ([1e3, 2e3], [2e3, 2.8e3], [2.8e3, 3.2e3], [4e3, 8e3]):
        band = signal.butter(6, edges, "bandpass", fs=RATE, output="sos")
        expected, found = ((signal.sosfilt(band, one, axis=0) ** 2).mean(axis=0) for one in (samples, noise))
        assert found == pytest.approx(expected, rel=0.12), edges


def test_it_is_gaussian_without_the_impacts_of_the_signal() -> None:
    samples = ringing(8.0)
    noise = following(samples)[round(RATE) :]
    assert stats.kurtosis(samples[:, 0], fisher=False) > 15.0
    assert stats.kurtosis(noise, fisher=False) == pytest.approx([3.0, 3.0], abs=0.15)
    assert abs(np.corrcoef(noise.T)[0, 1]) < 0.05
    power = (noise[: len(noise) // PERIOD * PERIOD, 0] ** 2).reshape(-1, PERIOD).mean(axis=0)  # over one period of the impacts
    assert power.std() / power.mean() < 2.0 * np.sqrt(2.0 / (len(noise) / PERIOD))


def test_it_begins_after_two_half_frames_and_follows_a_change() -> None:
    """After a change the power approaches its new value with the time constant."""
    white = np.random.default_rng(3).standard_normal((round(6.0 * RATE), 2))
    white[: round(2.0 * RATE)] *= 0.1
    noise = following(white, smoothing=0.5)
    assert not noise[: 2 * 1024].any()
    assert noise[2 * 1024 : 4 * 1024].any()
    for time in (0.25, 0.5, 1.0):
        begin = round((2.0 + time) * RATE)
        power = np.mean(noise[begin - 2048 : begin + 2048] ** 2)
        assert power == pytest.approx(1.0 - 0.99 * np.exp(-time / 0.5), abs=0.12), time

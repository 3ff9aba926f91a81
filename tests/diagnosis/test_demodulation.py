"""Demodulation of signals whose squared envelope is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy.signal import lfilter, windows

from dcrb_ros.diagnosis.demodulation import TAPER, Band, Demodulator, band_tree, kurtosis, tukey

RATE = 51200
TIME = np.arange(2 * RATE) / RATE
Floats = npt.NDArray[np.float64]
WHOLE = Band(2000.0, 20000.0)


def envelope(signal: Floats, band: Band = WHOLE) -> tuple[Floats, Floats]:
    """Return positions [samples] and the squared envelope there, without the ends that wrap round."""
    ((positions, squared),) = Demodulator((band,), RATE, len(signal)).squared_envelopes(signal.reshape(len(signal), -1))
    inside = (positions > 400.0) & (positions < len(signal) - 400.0)
    return positions[inside], squared[inside]


def test_envelope_of_a_tone_is_its_squared_amplitude() -> None:
    _, squared = envelope(5.0 * np.cos(2.0 * math.pi * 6000.0 * TIME))
    np.testing.assert_allclose(squared, 25.0, rtol=1e-6)


def test_envelope_sums_the_axes() -> None:
    tone = np.sin(2.0 * math.pi * 6000.0 * TIME)
    _, squared = envelope(np.column_stack([3.0 * tone, 4.0 * tone]))
    np.testing.assert_allclose(squared, 25.0, rtol=1e-6)


@pytest.mark.parametrize("frequency", [0.0, 500.0, 1900.0, 20100.0, 23000.0])
def test_envelope_excludes_frequencies_outside_the_band(frequency: float) -> None:
    _, squared = envelope(100.0 * np.cos(2.0 * math.pi * frequency * TIME))
    assert float(squared.max()) < 1e-6 * 100.0**2


def test_mean_of_the_envelope_is_twice_the_power_in_the_band() -> None:
    _, squared = envelope(np.random.default_rng(1).normal(size=len(TIME)))
    # White noise of unit power has 2 (band) / rate of it in the band; the edges, a tenth each, count 3/8.
    assert float(squared.mean()) == pytest.approx(2.0 * 18000.0 * (0.8 + 0.2 * 0.375) / (RATE / 2), rel=0.02)


def coloured(depth: float) -> Floats:
    """Return noise modulated at 100 Hz beside a mode at 5 kHz that has most of the power and is not modulated."""
    random = np.random.default_rng(4)
    wide = random.normal(size=len(TIME)) * np.sqrt(1.0 + depth * np.cos(2.0 * math.pi * 100.0 * TIME))
    poles = 0.98 * np.exp(2j * math.pi * 5000.0 / RATE)
    return wide + 0.5 * lfilter([1.0], np.poly([poles, np.conj(poles)]).real, random.normal(size=len(TIME)))


def modulation(signal: Floats, whitening: float) -> tuple[float, float]:
    """Return the depth at 100 Hz, and the mean of the squared envelope."""
    ((positions, squared),) = Demodulator((WHOLE,), RATE, len(signal), whitening).squared_envelopes(signal[:, None])
    line = 2.0 * abs(np.mean(squared * np.exp(-2j * math.pi * 100.0 * positions / RATE)))
    return float(line / squared.mean()), float(squared.mean())


def test_whitening_shows_what_a_mode_hides_and_keeps_the_power() -> None:
    (raw, power), (white, same) = (modulation(coloured(0.5), width) for width in (0.0, 500.0))
    assert same == pytest.approx(power, rel=1e-4)
    # The mode has nine tenths of the power; whitened over less than its width it has little more than its share of the band. The noise is
    # 24 dB below the mode, so that its power is lifted to 0.7 of that of the mode.
    assert raw < 0.1
    assert white > 0.28


@pytest.mark.parametrize(("below", "seen"), [(10.0, True), (60.0, False)])
def test_whitening_does_not_lift_what_is_far_below_the_loudest_part(below: float, seen: bool) -> None:
    """Above 8 kHz the noise is modulated at 100 Hz and fainter; a third of the band is below."""
    random, frequency = np.random.default_rng(6), np.fft.rfftfreq(len(TIME), 1.0 / RATE)
    low, high = (
        np.fft.irfft(np.fft.rfft(random.normal(size=len(TIME)) * gain) * part, len(TIME))
        for gain, part in ((1.0, frequency < 8000.0), (1.0 + 0.9 * np.cos(2.0 * math.pi * 100.0 * TIME), frequency >= 8000.0))
    )
    depth, _ = modulation(low + 10.0 ** (-below / 20.0) * high, 500.0)
    assert (depth > 0.3) is seen
    assert seen or depth < 0.05


def test_whitening_needs_no_unit() -> None:
    signal = coloured(0.5)[: RATE // 2]
    ((_, one),), ((_, other),) = (
        Demodulator((WHOLE,), RATE, len(signal), 500.0).squared_envelopes(gain * signal[:, None]) for gain in (1e-4, 1e4)
    )
    np.testing.assert_allclose(other, 1e16 * one, rtol=1e-4)


def test_silence_is_not_whitened() -> None:
    ((_, squared),) = Demodulator((WHOLE,), RATE, RATE, 500.0).squared_envelopes(np.zeros((RATE, 2)))
    assert not squared.any()


def test_kurtosis_of_noise_is_zero_and_of_impacts_large() -> None:
    # The squared envelope of Gaussian noise is exponential, whose second moment is twice its squared mean: 0. A share p of
    # the time that holds all of a constant power has 1/p - 2.
    noise = np.random.default_rng(2).exponential(size=200000)
    burst = np.where(np.arange(200000) % 20 == 0, 5.0, 0.0)
    assert kurtosis(np.stack([noise, burst, np.zeros(200000)])) == pytest.approx([0.0, 18.0, 0.0], abs=0.1)


def test_bands_are_divided_on_a_logarithmic_scale() -> None:
    assert [(round(band.low), round(band.high)) for band in band_tree(1000.0, 16000.0)] == [
        (1000, 16000),
        (1000, 4000),
        (4000, 16000),
        (1000, 2520),
        (2520, 6350),
        (6350, 16000),
        (1000, 2000),
        (2000, 4000),
        (4000, 8000),
        (8000, 16000),
    ]


@pytest.mark.parametrize("length", [1, 2, 3, 10, 11, 4096, 22501])
def test_window_equals_that_of_scipy(length: int) -> None:
    assert tukey(length, TAPER).tolist() == windows.tukey(length, TAPER).tolist()


def tonal(signal: Floats, *, tones: bool) -> Floats:
    """Return the squared envelope of a signal whose spectrum is whitened."""
    ((_, squared),) = Demodulator((WHOLE,), RATE, len(signal), 500.0, tones=tones).squared_envelopes(signal[:, None])
    return squared


def test_tones_that_beat_are_removed() -> None:
    noise = np.random.default_rng(5).normal(size=len(TIME))
    beating = noise + 3.0 * np.cos(2.0 * math.pi * 11874.3 * TIME) + np.cos(2.0 * math.pi * 11964.3 * TIME)
    depth = [
        abs(np.fft.rfft(squared)[round(90.0 * len(TIME) / RATE)]) * 2.0 / squared.sum()
        for squared in (tonal(beating, tones=kept) for kept in (True, False))
    ]
    assert depth[0] > 0.02
    assert depth[1] < 0.01


def test_periodic_impacts_are_no_tones() -> None:
    impacts = np.random.default_rng(5).normal(scale=0.01, size=len(TIME))
    impacts[:: RATE // 200] += 10.0
    np.testing.assert_array_equal(tonal(impacts, tones=False), tonal(impacts, tones=True))

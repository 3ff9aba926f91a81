"""Families of features against signals whose features are known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import firwin

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.features.band_levels import BAND_LEVELS, middles
from dcrb_ros.diagnosis.features.cepstrum import CEPSTRUM
from dcrb_ros.diagnosis.features.envelope_lines import ENVELOPE_LINES
from dcrb_ros.diagnosis.features.family import FAULTS, FeatureFamily, Windows
from dcrb_ros.diagnosis.features.kurtogram import KURTOGRAM, impulsive_band
from dcrb_ros.diagnosis.features.registry import FAMILIES
from dcrb_ros.diagnosis.features.spectral_coherence import SPECTRAL_COHERENCE
from dcrb_ros.diagnosis.features.statistics import STATISTICS

RATE = 25600
TIME = np.arange(2 * RATE) / RATE
SPEED = 20.0
"""Shaft frequency [Hz]."""
ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.06)
Floats = npt.NDArray[np.float64]


def windows(signal: Floats, turns: Floats | None = None, rate: int = RATE) -> Windows:
    angle = SPEED * np.arange(signal.shape[-1]) / rate if turns is None else turns
    values = np.atleast_2d(signal)
    return Windows(values, np.broadcast_to(angle, values.shape), rate, ORDERS)


def named(family: FeatureFamily, given_windows: Windows) -> dict[str, float]:
    return dict(zip(family.names(given_windows.rate), family.compute(given_windows)[0].tolist(), strict=True))


def noise(seed: int = 1, scale: float = 1.0, samples: int = len(TIME)) -> Floats:
    return np.asarray(np.random.default_rng(seed).normal(scale=scale, size=samples), np.float64)


def impacts(turns: Floats, order: float, resonance: float = 5000.0) -> Floats:
    """Return a train of decaying vibrations, one at each passage of a fault of an order, over turns of the shaft."""
    train = np.zeros(len(turns))
    train[np.flatnonzero(np.diff(np.floor(turns * order)) > 0)] = 1.0
    decay = np.arange(200) / RATE
    return np.convolve(train, np.exp(-2000.0 * decay) * np.sin(2.0 * np.pi * resonance * decay))[: len(turns)]


def test_statistics_of_a_tone_are_those_of_a_sine() -> None:
    found = named(STATISTICS, windows(3.0 * np.sin(2.0 * np.pi * 200.0 * TIME)))
    assert found["rms"] == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-6)
    assert found["peak"] == pytest.approx(3.0, rel=1e-6)
    assert found["crest_factor"] == pytest.approx(np.sqrt(2.0), rel=1e-6)
    assert found["kurtosis"] == pytest.approx(1.5, rel=1e-6)
    assert found["skewness"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("samples", [256, RATE])
def test_a_window_without_vibration_has_finite_statistics(samples: int) -> None:
    """The mean is removed before."""
    silent = windows(np.zeros(samples))
    found = named(STATISTICS, silent) | named(KURTOGRAM, silent)
    assert np.isfinite(list(found.values())).all()
    assert (found["kurtogram_kurtosis"], found["kurtosis"], found["skewness"]) == (0.0, 0.0, 0.0)


def test_a_window_too_short_for_a_band_has_no_impulsive_band() -> None:
    assert named(KURTOGRAM, windows(noise(samples=1000))) == dict.fromkeys(
        ("kurtogram_kurtosis", "kurtogram_frequency", "kurtogram_bandwidth"), 0.0
    )


@pytest.mark.parametrize("middle", [100.0, 1000.0, 10000.0])
def test_a_tone_is_in_its_third_octave_alone(middle: float) -> None:
    found = named(BAND_LEVELS, windows(2.0 * np.sin(2.0 * np.pi * middle * TIME)))
    levels = np.array(list(found.values()))
    assert middles(RATE)[levels.argmax()] == pytest.approx(middle)
    assert levels.max() == pytest.approx(10.0 * np.log10(2.0), abs=0.05)
    assert np.sort(levels)[-2] < levels.max() - 20.0


def test_the_bands_of_white_noise_rise_by_a_decibel_each() -> None:
    """Each band is wider than the one below it by 10^(1/10), which is 1 dB."""
    values = np.array([BAND_LEVELS.compute(windows(noise(seed)))[0] for seed in range(8)]).mean(axis=0)
    assert np.polyfit(np.arange(len(values)), values, 1)[0] == pytest.approx(1.0, abs=0.03)
    density = 10.0 ** (values / 10.0) / (middles(RATE) * (10.0**0.05 - 10.0**-0.05))
    assert density[-8:].mean() == pytest.approx(2.0 / RATE, rel=0.03)  # one-sided, of noise with a variance of 1


def test_impacts_are_found_in_the_band_of_their_resonance() -> None:
    signal = 0.2 * noise() + impacts(SPEED * TIME, ORDERS.bpfo)
    found = named(KURTOGRAM, windows(signal))
    assert found["kurtogram_kurtosis"] > 2.0
    assert abs(found["kurtogram_frequency"] - 5000.0) < 1500.0
    quiet = impulsive_band(noise(), RATE).kurtosis[0]
    assert quiet < 0.6
    assert impulsive_band(noise() + 50.0, RATE).kurtosis[0] == pytest.approx(quiet, abs=1e-3)  # gravity is no impact


def test_the_ends_of_a_window_are_no_impact_above_the_anti_alias_filter() -> None:
    """The repeated window jumps between its ends. A recording with an empty band below half its rate shows nothing else there."""
    taps = firwin(401, 0.43 * RATE, fs=RATE, window=("kaiser", 10.0))
    drift = 2.0 * np.sin(2.0 * np.pi * 0.37 * TIME)  # no whole number of periods
    healthy = np.convolve(noise(samples=len(TIME) + 400), taps, "valid") + drift
    damaged = healthy + 5.0 * impacts(SPEED * TIME, ORDERS.bpfo)
    band = impulsive_band(np.stack([healthy, damaged]), RATE)
    assert band.kurtosis[0] < 0.6
    assert band.low[1] < 5000.0 < band.high[1] <= 0.45 * RATE
    assert band.kurtosis[1] > 2.0


@pytest.mark.parametrize("fault", range(4))
def test_the_lines_of_a_fault_are_its_own(fault: int) -> None:
    order = (ORDERS.bpfo, ORDERS.bpfi, 2.0 * ORDERS.bsf, ORDERS.ftf)[fault]
    signal = windows(0.1 * noise() + impacts(SPEED * TIME, 1.01 * order))
    lines = named(ENVELOPE_LINES, signal)
    depths = {name: lines[f"wide_{name}_depth"] for name in FAULTS}
    assert max(depths, key=lambda name: depths[name]) == FAULTS[fault]
    assert lines[f"wide_{FAULTS[fault]}_significance"] > 6.0
    coherence = named(SPECTRAL_COHERENCE, signal)
    assert max(coherence, key=lambda name: coherence[name]) == f"coherence_{FAULTS[fault]}"


@pytest.mark.parametrize("fault", range(3))
def test_echoes_are_a_peak_of_the_cepstrum(fault: int) -> None:
    """x(t) + a x(t - T) has the cepstrum a/2 at T, and nothing at the periods of the other faults."""
    order = (ORDERS.bpfo, ORDERS.bpfi, 2.0 * ORDERS.bsf)[fault]
    source, delay = noise(), round(RATE / (SPEED * 1.01 * order))
    found = named(CEPSTRUM, windows(source + 0.5 * np.roll(source, delay)))
    assert max(found, key=lambda name: found[name]) == f"cepstrum_{FAULTS[fault]}"
    assert found[f"cepstrum_{FAULTS[fault]}"] > 8.0
    assert sorted(found.values())[-2] < 5.0


def test_a_low_sampling_rate_has_a_coherence_too() -> None:
    rate = 5120
    signal = noise(samples=4 * rate)
    found = named(SPECTRAL_COHERENCE, windows(signal, rate=rate))
    assert all(np.isfinite(value) for value in found.values())


def test_a_varying_speed_does_not_hide_a_fault() -> None:
    turns = SPEED * TIME + 0.4 * np.sin(2.0 * np.pi * 1.5 * TIME)
    signal = 0.1 * noise() + impacts(turns, ORDERS.bpfo)
    for family, name in ((ENVELOPE_LINES, "wide_BPFO_depth"), (SPECTRAL_COHERENCE, "coherence_BPFO")):
        tracked, untracked = named(family, windows(signal, turns))[name], named(family, windows(signal))[name]
        assert tracked > 1.5 * untracked


@settings(max_examples=10, deadline=None)
@given(gain=st.floats(1e-3, 1e3), seed=st.integers(0, 20))
def test_the_gain_changes_levels_alone(gain: float, seed: int) -> None:
    signal = noise(seed, samples=RATE // 2) + impacts(SPEED * TIME[: RATE // 2], ORDERS.bpfi)
    for family in FAMILIES:
        before, after = named(family, windows(signal)), named(family, windows(gain * signal))
        for name, value in before.items():
            expected = value * gain if name in ("rms", "peak") else value + 20.0 * np.log10(gain) if "level_" in name else value
            assert after[name] == pytest.approx(expected, rel=1e-3, abs=1e-3), name

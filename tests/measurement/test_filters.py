"""The filters of the measurement chain, with analytic signals."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy import signal

from dcrb_ros.measurement.filters import Filter, band_of_noise, high_pass, low_pass, pink, resonance, side_by_side, transmissibility
from dcrb_ros.measurement.stages.structure import modes, sections
from dcrb_ros.settings.sensor import Structure

RATE = 102400.0


def gain(filter_sections: npt.NDArray[np.float64], frequency: float) -> float:
    """Return the gain of a filter at a frequency [Hz], from the settled response to a tone."""
    count = round(RATE)
    phase = 2.0 * np.pi * frequency * np.arange(count) / RATE
    out = Filter(filter_sections, columns=1).process(np.sin(phase)[:, None])[:, 0]
    last = slice(-round(RATE / 10), None)  # whole periods of multiples of 10 Hz
    return 2.0 * abs(np.mean(out[last] * np.exp(-1j * phase[last])))


@pytest.mark.parametrize(("frequency", "damping"), [(800.0, 0.1), (5000.0, 0.02), (25000.0, 0.03)])
def test_a_resonance_has_its_peak_and_static_gain_one(frequency: float, damping: float) -> None:
    found = resonance(frequency, damping, RATE)
    assert gain(found, frequency) == pytest.approx(0.5 / damping, rel=1e-6)
    assert gain(found, 10.0) == pytest.approx(1.0, rel=3e-4)
    peak = math.sqrt(1.0 + 4.0 * damping**2) / (2.0 * damping)  # |1 + 2 i zeta| / (2 zeta)
    assert gain(transmissibility(frequency, damping, RATE), frequency) == pytest.approx(peak, rel=1e-6)


def test_low_pass_and_high_pass_attenuate_three_decibels_at_their_corner() -> None:
    assert 20.0 * math.log10(gain(low_pass(11000.0, RATE), 11000.0)) == pytest.approx(-3.01, abs=0.01)
    assert 20.0 * math.log10(gain(high_pass(100.0, RATE), 100.0)) == pytest.approx(-3.01, abs=0.01)
    assert 20.0 * math.log10(gain(high_pass(100.0, RATE), 10.0)) == pytest.approx(-20.04, abs=0.01)


def test_sections_in_series_equal_the_modes_in_parallel() -> None:
    structure = Structure(modes=24, coupling=0.7)
    found = modes(structure)
    frequencies = np.geomspace(1.0, 0.49 * RATE, 3000)
    bank = [transmissibility(mode.frequency, mode.damping, RATE) for mode in found]
    for axis, together in enumerate(sections(structure, RATE)):
        alone = 0.3 + sum(0.7 * m.share[axis] * signal.sosfreqz(b, frequencies, fs=RATE)[1] for m, b in zip(found, bank, strict=True))
        assert np.abs(signal.sosfreqz(together, frequencies, fs=RATE)[1] / alone - 1.0).max() < 1e-6
    assert np.abs(signal.sos2zpk(together)[1]).max() < 1.0


def test_random_modes_are_within_the_range_of_an_axle_box() -> None:
    found = modes(Structure(modes=8, seed=3))
    assert found == modes(Structure(modes=8, seed=3))
    assert found != modes(Structure(modes=8, seed=4))
    assert all(500.0 <= mode.frequency <= 8000.0 and 0.01 <= mode.damping <= 0.05 for mode in found)
    assert np.sum([mode.share for mode in found], axis=0) == pytest.approx([1.0, 1.0])
    given = modes(Structure(frequencies="900, 2300", dampings="0.03 0.01"))
    assert [(mode.frequency, mode.damping) for mode in given] == [(900.0, 0.03), (2300.0, 0.01)]


def test_an_impulse_decays_with_the_damping_of_the_mode() -> None:
    frequency, damping = 2000.0, 0.02
    bank = side_by_side([transmissibility(frequency, damping, RATE)], [1.0], 0.0)
    blow = np.zeros((4096, 1))
    blow[0] = 1.0
    ringing = np.abs(signal.hilbert(Filter(bank, columns=1).process(blow)[:, 0]))[50:1500]
    slope = np.polyfit(np.arange(len(ringing)) / RATE, np.log(ringing), 1)[0]
    assert slope == pytest.approx(-damping * 2.0 * np.pi * frequency, rel=0.01)


def test_the_density_of_pink_noise_falls_with_the_root_of_the_frequency() -> None:
    frequencies = np.geomspace(0.2, 10000.0, 200)
    density = np.abs(signal.sosfreqz(pink(51200.0), frequencies, fs=51200.0)[1]) * math.sqrt(2.0 / 51200.0)
    assert np.abs(20.0 * np.log10(density * np.sqrt(frequencies))).max() < 0.3


def test_band_limited_noise_has_rms_one() -> None:
    noise = np.random.default_rng(2).standard_normal((1 << 19, 1))
    out = Filter(band_of_noise(20.0, 1500.0, RATE), columns=1).process(noise)
    assert out.std() == pytest.approx(1.0, rel=0.03)


def test_the_compiled_filter_equals_that_of_scipy() -> None:
    samples, cascade = np.random.default_rng(3).standard_normal((5000, 2)), pink(51200.0)
    assert Filter(cascade).process(samples) == pytest.approx(signal.sosfilt(cascade, samples, axis=0), rel=1e-9, abs=1e-12)

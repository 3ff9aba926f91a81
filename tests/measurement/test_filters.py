"""The filters of the measurement chain, with analytic signals."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy import signal

from dcrb_ros.measurement.filters import (
    Filter,
    above_step_rate,
    band_of_noise,
    high_pass,
    low_pass,
    noise_gain,
    pink,
    resonance,
    side_by_side,
    transmissibility,
)
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


def response(filter_sections: npt.NDArray[np.float64], frequencies: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the gain of a filter at frequencies [Hz]."""
    return np.abs(signal.sosfreqz(filter_sections, np.asarray(frequencies, float), fs=RATE)[1])


def test_filters_have_the_order_of_butterworth() -> None:
    """|H|^2 = 1 / (1 + r^2n) with r the ratio of prewarped frequencies tan(pi f / rate)."""
    frequencies = np.array([50.0, 500.0, 3000.0, 11000.0, 40000.0])
    warped = np.tan(np.pi * frequencies / RATE)
    corner = math.tan(math.pi * 3000.0 / RATE)
    assert response(low_pass(3000.0, RATE), frequencies) == pytest.approx(1.0 / np.sqrt(1.0 + (warped / corner) ** 4), rel=1e-6)
    assert response(high_pass(3000.0, RATE), frequencies) == pytest.approx(1.0 / np.sqrt(1.0 + (corner / warped) ** 2), rel=1e-6)


def test_a_band_of_noise_has_its_edges_and_unit_power() -> None:
    found = band_of_noise(200.0, 1500.0, RATE)
    assert noise_gain(found) == pytest.approx(1.0, rel=1e-8)
    frequencies = np.linspace(0.0, 0.5 * RATE, 400001)
    assert np.mean(response(found, frequencies) ** 2) == pytest.approx(1.0, rel=1e-4)
    middle = math.sqrt(200.0 * 1500.0)
    assert response(found, [200.0, 1500.0]) / response(found, [middle]) == pytest.approx(math.sqrt(0.5), rel=1e-2)
    assert response(found, [20.0, 15000.0]).max() < 0.02 * response(found, [middle])[0]  # 40 dB per decade


@pytest.mark.parametrize("rate", [12800.0, 51200.0, 102400.0])
def test_pink_noise_follows_one_over_f_from_a_tenth_of_a_hertz_on(rate: float) -> None:
    """White noise of rms 1 has a one-sided density of sqrt(2 / rate)."""
    frequencies = np.geomspace(0.15, 0.25 * rate, 500)
    cascade = pink(rate)
    density = np.abs(signal.sosfreqz(cascade, frequencies, fs=rate)[1]) * math.sqrt(2.0 / rate)
    assert np.abs(20.0 * np.log10(density * np.sqrt(frequencies))).max() < 0.8
    assert np.abs(signal.sosfreqz(cascade, [1.0], fs=rate)[1][0]) * math.sqrt(2.0 / rate) == pytest.approx(1.0)
    white = np.abs(signal.sosfreqz(cascade, [1e-3, 5e-3], fs=rate)[1])
    assert white[1] == pytest.approx(white[0], rel=0.02)
    decades = math.log10(0.5 * rate / 0.05)
    assert len(signal.sos2zpk(cascade)[1]) == pytest.approx(2.0 * decades, abs=2.0)


def test_a_filter_may_reach_up_to_0_45_of_the_step_rate() -> None:
    assert list(above_step_rate("sensor.bandwidth", 45000.0, 100000)) == []
    (sentence,) = above_step_rate("sensor.bandwidth", 45000.1, 100000)
    assert "above 45000 Hz, 0.45 of the step rate" in sentence


def test_the_memory_of_a_filter_starts_at_zero_in_each_column() -> None:
    found = Filter(low_pass(3000.0, RATE), high_pass(10.0, RATE))
    impulse = np.zeros((200, 2))
    impulse[0, 1] = 1.0
    out = found.process(impulse)
    assert not out[:, 0].any()
    assert out[:, 1] == pytest.approx(signal.sosfilt(np.concatenate([low_pass(3000.0, RATE), high_pass(10.0, RATE)]), impulse[:, 1]))

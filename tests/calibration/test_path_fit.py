"""The fit of a path between two spectra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import sosfreqz

from dcrb_ros.calibration.path_fit import ROBUST, PathSpectra, _residuals, fit_path
from dcrb_ros.calibration.spectra import Binned, binned, power_density, third_octaves
from dcrb_ros.measurement.stages.path import Pair, cascade
from dcrb_ros.schema.arrays import Floats

RATE, STEPS = 51200, 102400.0
FREQUENCY = np.geomspace(100.0, 20000.0, 360)
SOURCE = -2.0 * np.log(1.0 + (FREQUENCY / 1500.0) ** 2)


def data(pairs: list[Pair], gain: float, white: float, *, recordings: int = 1, seed: int = 0) -> PathSpectra:
    """Return spectra with the scatter of 30 averages, the source's falling by 12 dB per octave above 1.5 kHz."""
    response = np.abs(sosfreqz(cascade(pairs, STEPS), FREQUENCY, fs=STEPS)[1])
    power = gain**2 * response**2 * np.exp(SOURCE) + white**2
    random = np.random.default_rng(seed)
    measured = [
        Binned(FREQUENCY, np.log(power) + random.normal(0.0, 0.15, len(power)), np.full(len(power), 0.0225)) for _ in range(recordings)
    ]
    return PathSpectra.of(measured, [Binned(FREQUENCY, SOURCE, np.zeros(len(power)))] * recordings, 200.0, STEPS)


pairs = st.builds(
    lambda pole, ratio, damping, other: Pair(pole, damping, pole * ratio, other),
    st.floats(400.0, 4000.0),
    st.floats(0.8, 1.25),
    st.floats(0.02, 0.1),
    st.floats(0.02, 0.1),
)


@settings(max_examples=15)
@given(pairs, st.floats(0.01, 100.0), st.floats(1e-2, 4e-2))
def test_a_pair_gain_and_noise_are_found(pair: Pair, gain: float, noise: float) -> None:
    white = noise * gain
    spectra = data([pair], gain, white)
    found = fit_path(spectra)
    true = 2.0 * np.log(gain * np.abs(sosfreqz(cascade([pair], STEPS), FREQUENCY, fs=STEPS)[1]))
    heard = (found.share()[0] > 0.5) & (FREQUENCY >= 200.0)
    error = 4.343 * (2.0 * np.log(found.gains[0]) + found.log_path() - true)[heard]
    assert np.sqrt(np.mean(error**2)) < 0.7
    assert found.white == pytest.approx(white, rel=0.1)
    residual = _residuals(found.parameters, spectra)[0][: spectra.measured.size]
    assert np.sqrt(np.mean(np.minimum(np.abs(residual), ROBUST) ** 2)) < 1.4


def test_recordings_of_one_machine_share_the_path_and_have_gains_of_their_own() -> None:
    one = data([Pair(1500.0, 0.03, 1900.0, 0.04)], 1.0, 1e-3, recordings=2)
    louder = PathSpectra(one.frequency, one.measured + np.array([[0.0], [2.0 * np.log(3.0)]]), one.source, one.deviation, one.step_rate)
    found = fit_path(louder, white=1e-4)
    assert found.gains[1] / found.gains[0] == pytest.approx(3.0, rel=0.02)


def test_a_flat_path_has_no_pairs() -> None:
    found = fit_path(data([Pair(1000.0, 0.5, 1000.0, 0.5)], 2.0, 1e-2))
    assert found.pairs == ()
    assert found.gains[0] == pytest.approx(2.0, rel=0.03)


def test_derivatives_are_those_of_the_residuals() -> None:
    spectra = data([Pair(1500.0, 0.03, 1900.0, 0.04)], 1.0, 1e-2, recordings=2)
    at = np.array([-9.0, 0.1, -0.2, 7.0, -2.0, 7.2, -3.0, 8.5, -1.0, 8.4, -0.5])

    def values(parameters: Floats) -> Floats:
        return _residuals(parameters, spectra)[0]

    numeric = np.array([(values(at + step) - values(at - step)) / 2e-6 for step in 1e-6 * np.eye(len(at))]).T
    assert _residuals(at, spectra)[1] == pytest.approx(numeric, abs=1e-5)


def test_the_level_of_white_noise_in_bins_is_its_density() -> None:
    noise = np.random.default_rng(3).standard_normal(10 * RATE)
    level = binned(power_density(noise, RATE), RATE).level
    assert np.mean(level[-100:]) == pytest.approx(np.log(2.0 / RATE), abs=0.01)


def test_third_octaves_hold_the_power_of_a_tone() -> None:
    tone = np.sqrt(2.0) * np.sin(2.0 * np.pi * 1000.0 * np.arange(4 * RATE) / RATE)
    middle, level = third_octaves(power_density(tone, RATE), RATE)
    assert level[np.argmin(np.abs(middle - 1000.0))] == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("rate", [18200, 36300, 51200, 72500])
def test_signals_of_two_seconds_and_more_have_the_same_bins(rate: int) -> None:
    random = np.random.default_rng(1)
    short, long = (binned(power_density(random.standard_normal(seconds * rate), rate), rate) for seconds in (2, 10))
    assert np.array_equal(short.frequency, long.frequency)

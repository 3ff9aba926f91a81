"""Bands, angle bins and order spectra against signals whose envelope is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import windows

from dcrb_ros.diagnosis.bands import TAPER, Band, BandBank, band_tree, kurtosis, tukey
from dcrb_ros.diagnosis.envelope import OrderSpectrum, combs, fitted_orders, median, order_spectra
from dcrb_ros.diagnosis.turning import bin_means, borders_between, turns_back, turns_of

RATE = 51200
TIME = np.arange(2 * RATE) / RATE
Floats = npt.NDArray[np.float64]
WHOLE = Band(2000.0, 20000.0)
BINS = 96


def envelope(signal: Floats, band: Band = WHOLE) -> tuple[Floats, Floats]:
    """Return places [samples] and the squared envelope there, without the ends that wrap round."""
    ((places, squared),) = BandBank((band,), RATE, len(signal)).squared_envelopes(signal.reshape(len(signal), -1))
    inside = (places > 400.0) & (places < len(signal) - 400.0)
    return places[inside], squared[inside]


def spectrum(signal: Floats, turns: Floats) -> OrderSpectrum:
    """Return the order spectrum of a signal's squared envelope over the turns of the shaft."""
    places, squared = envelope(signal)
    begin, end = np.interp(places[[0, -1]], np.arange(len(turns)), turns)
    borders = borders_between(begin, end, BINS)[1:]
    means = bin_means(places, squared, np.interp(borders, turns, np.arange(len(turns))))
    return order_spectra(means[None, :], np.zeros(len(means), np.bool_), BINS)[0]


def modulated(order: float, turns: Floats, *, depth: float = 0.4, amplitude: float = 3.0) -> Floats:
    """Return a 7 kHz carrier whose amplitude is modulated at an order of the shaft."""
    carrier = np.sin(2.0 * math.pi * 7000.0 * TIME)
    return np.asarray(amplitude * (1.0 + depth * np.cos(2.0 * math.pi * order * turns)) * carrier)


def test_envelope_of_a_tone_is_its_squared_amplitude() -> None:
    _, squared = envelope(5.0 * np.cos(2.0 * math.pi * 6000.0 * TIME))
    np.testing.assert_allclose(squared, 25.0, rtol=1e-6)


def test_envelope_sums_the_axes() -> None:
    tone = np.sin(2.0 * math.pi * 6000.0 * TIME)
    _, squared = envelope(np.column_stack([3.0 * tone, 4.0 * tone]))
    np.testing.assert_allclose(squared, 25.0, rtol=1e-6)


@pytest.mark.parametrize("frequency", [0.0, 500.0, 1900.0, 20100.0, 23000.0])
def test_envelope_leaves_out_what_is_outside_the_band(frequency: float) -> None:
    _, squared = envelope(100.0 * np.cos(2.0 * math.pi * frequency * TIME))
    assert float(squared.max()) < 1e-6 * 100.0**2


def test_mean_of_the_envelope_is_twice_the_power_in_the_band() -> None:
    _, squared = envelope(np.random.default_rng(1).normal(size=len(TIME)))
    # White noise of unit power has 2 (band) / rate of it in the band; the edges, a tenth each, count 3/8.
    assert float(squared.mean()) == pytest.approx(2.0 * 18000.0 * (0.8 + 0.2 * 0.375) / (RATE / 2), rel=0.02)


def test_kurtosis_is_that_of_noise_and_of_impacts() -> None:
    # The squared envelope of Gaussian noise is exponential, whose second moment is twice its squared mean: 0. A share p of
    # the time that holds all of a constant power has 1/p - 2.
    noise = np.random.default_rng(2).exponential(size=200000)
    burst = np.where(np.arange(200000) % 20 == 0, 5.0, 0.0)
    assert kurtosis(np.stack([noise, burst, np.zeros(200000)])) == pytest.approx([0.0, 18.0, 0.0], abs=0.1)


def test_tree_halves_on_a_logarithmic_scale() -> None:
    assert [(round(band.low), round(band.high)) for band in band_tree(1000.0, 16000.0, 2)] == [
        (1000, 16000),
        (1000, 4000),
        (4000, 16000),
        (1000, 2000),
        (2000, 4000),
        (4000, 8000),
        (8000, 16000),
    ]


@pytest.mark.parametrize("order", [3.3, 6.71, 9.28])
@pytest.mark.parametrize("frequency", [9.55, 20.0, 30.24])
def test_spectrum_shows_the_order_and_the_amplitude(order: float, frequency: float) -> None:
    found = spectrum(modulated(order, frequency * TIME), frequency * TIME)
    peak = int(np.argmax(found.amplitude[3:])) + 3
    assert found.orders[peak] == pytest.approx(order, abs=0.5 / (2.0 * frequency))
    # (A (1 + m cos))^2 = A^2 (1 + m^2/2 + 2 m cos + m^2/2 cos 2): 2 m A^2 at the order.
    assert found.amplitude[peak] == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert found.mean == pytest.approx(9.0 * (1.0 + 0.5 * 0.4**2), rel=0.02)


def test_ramp_of_the_speed_does_not_smear_the_order() -> None:
    turns = 12.0 * TIME + 6.0 * TIME**2  # 12 to 36 Hz
    found = spectrum(modulated(6.71, turns), turns)
    assert fitted_orders(found, [6.7], 0.004) == pytest.approx(6.71, abs=0.01)
    (line,) = combs(found, [(6.71, np.array([6.71]))])
    assert line.amplitude == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert line.depth == pytest.approx(2.0 * 0.4 / (1.0 + 0.5 * 0.4**2), rel=0.06)
    assert line.level > 30.0


def test_missing_bins_keep_mean_and_amplitude() -> None:
    place = np.arange(8000) / 100.0
    values = 5.0 + 2.0 * np.cos(2.0 * math.pi * 6.7 * place)
    missing = (np.arange(8000) // 50) % 10 == 3
    (found,) = order_spectra(np.where(missing, 1e6, values)[None, :], missing, 100)
    assert found.mean == pytest.approx(5.0, rel=0.01)
    assert found.lines([6.7])[0] == pytest.approx(2.0, rel=0.05)


@given(frequency=st.floats(4.0, 80.0), bins=st.integers(16, 256))
def test_angle_bins_keep_a_constant(frequency: float, bins: int) -> None:
    turns = frequency * TIME
    borders = borders_between(0.0, float(turns[-1]), bins)
    means = bin_means(np.arange(len(TIME), dtype=float), np.full(len(TIME), 7.0), np.interp(borders, turns, np.arange(len(TIME))))
    assert len(means) == pytest.approx(2.0 * frequency * bins, abs=2)
    np.testing.assert_allclose(means, 7.0, rtol=1e-9)


@given(frequency=st.floats(-60.0, 60.0))
def test_turns_come_back_from_wrapped_angles(frequency: float) -> None:
    angle = np.mod(2.0 * math.pi * frequency * TIME[:5000], 2.0 * math.pi).astype(np.float32)
    np.testing.assert_allclose(turns_of(angle), frequency * TIME[:5000], atol=1e-5)


def test_turning_back_is_told_from_jitter() -> None:
    there_and_back = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.2, 50)])
    jitter = np.linspace(0.0, 1.0, 100) + 0.001 * np.random.default_rng(1).normal(size=100)
    assert turns_back(there_and_back, 0.02)
    assert not turns_back(jitter, 0.02)
    assert not turns_back(-jitter, 0.02)


def test_comb_follows_the_family_and_not_a_foreign_line() -> None:
    orders = np.arange(0.0, 32.0, 0.01)
    amplitude = np.ones(len(orders), np.float32)
    for k in (1, 2, 3):
        amplitude[np.abs(orders - 6.71 * k) < 0.015] = 20.0
    amplitude[np.abs(orders - 6.745) < 0.004] = 300.0  # foreign, within the search
    found = OrderSpectrum(orders, amplitude, 10.0)
    assert fitted_orders(found, [6.7234], 0.004) == pytest.approx(6.71, abs=0.01)
    (family,) = combs(found, [(6.71, np.array([6.71, 13.42, 20.13]))])
    assert (family.amplitude, family.depth, family.level) == (20.0, 2.0, pytest.approx(13.0, abs=0.02))


def test_silence_has_no_lines() -> None:
    (found,) = order_spectra(np.zeros((1, 4000)), np.zeros(4000, np.bool_), 100)
    assert combs(found, [(6.7, np.array([6.7, 13.4]))])[0][1:] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("length", [1, 2, 3, 10, 11, 4096, 22501])
def test_window_is_the_one_of_scipy(length: int) -> None:
    assert tukey(length, TAPER).tolist() == windows.tukey(length, TAPER).tolist()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("length", [1, 2, 3, 15, 400, 4001])
def test_median_is_the_one_of_numpy(length: int, kind: type[np.floating]) -> None:
    values = np.random.default_rng(length).standard_normal(length).astype(kind)
    assert median(values) == np.median(values)

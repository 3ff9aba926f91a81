"""Squared envelope spectra of signals whose lines are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.line_search import Comb, LineSearch
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, decibels, medians, order_spectra, ratio
from dcrb_ros.diagnosis.order_tracking import bin_edges, bin_means

RATE = 51200
TIME = np.arange(2 * RATE) / RATE
Floats = npt.NDArray[np.float64]
BINS = 96


def spectrum(signal: Floats, turns: Floats) -> OrderSpectrum:
    """Return the order spectrum of a signal's squared envelope over the turns of the shaft."""
    ((positions, squared),) = Demodulator((Band(2000.0, 20000.0),), RATE, len(signal)).squared_envelopes(signal[:, None])
    inside = (positions > 400.0) & (positions < len(signal) - 400.0)  # the ends wrap round
    positions, squared = positions[inside], squared[inside]
    begin, end = np.interp(positions[[0, -1]], np.arange(len(turns)), turns)
    edges = bin_edges(begin, end, BINS)[1:]
    means = bin_means(positions, squared, np.interp(edges, turns, np.arange(len(turns))))
    return order_spectra(means[None, :], np.zeros(len(means), np.bool_), BINS)[0]


def modulated(order: float, turns: Floats, *, depth: float = 0.4, amplitude: float = 3.0) -> Floats:
    """Return a 7 kHz carrier whose amplitude is modulated at an order of the shaft."""
    carrier = np.sin(2.0 * math.pi * 7000.0 * TIME)
    return np.asarray(amplitude * (1.0 + depth * np.cos(2.0 * math.pi * order * turns)) * carrier)


@pytest.mark.parametrize("order", [3.3, 6.71, 9.28])
@pytest.mark.parametrize("frequency", [9.55, 20.0, 30.24])
def test_spectrum_has_the_line_at_its_order_with_its_amplitude(order: float, frequency: float) -> None:
    found = spectrum(modulated(order, frequency * TIME), frequency * TIME)
    peak = int(np.argmax(found.amplitude[3:])) + 3
    assert found.orders[peak] == pytest.approx(order, abs=0.5 / (2.0 * frequency))
    # (A (1 + m cos))^2 = A^2 (1 + m^2/2 + 2 m cos + m^2/2 cos 2): 2 m A^2 at the order.
    assert found.amplitude[peak] == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert found.mean == pytest.approx(9.0 * (1.0 + 0.5 * 0.4**2), rel=0.02)


def test_a_speed_ramp_does_not_smear_the_line() -> None:
    turns = 12.0 * TIME + 6.0 * TIME**2  # 12 to 36 Hz
    found = spectrum(modulated(6.71, turns), turns)
    line = LineSearch(found).best(Comb(6.7, harmonics=(1,)), 0.004)
    assert line.order == pytest.approx(6.71, abs=0.015)
    assert line.amplitude == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert line.depth == pytest.approx(2.0 * 0.4 / (1.0 + 0.5 * 0.4**2), rel=0.06)
    assert line.level > 30.0


def test_missing_bins_change_neither_mean_nor_amplitude() -> None:
    place = np.arange(8000) / 100.0
    values = 5.0 + 2.0 * np.cos(2.0 * math.pi * 6.7 * place)
    missing = (np.arange(8000) // 50) % 10 == 3
    (found,) = order_spectra(np.where(missing, 1e6, values)[None, :], missing, 100)
    assert found.mean == pytest.approx(5.0, rel=0.01)
    assert found.lines([6.7])[0] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("length", [1, 2, 3, 15, 400, 4001])
def test_median_equals_that_of_numpy(length: int, kind: type[np.floating]) -> None:
    values = np.random.default_rng(length).standard_normal(length).astype(kind)
    assert medians(values) == np.median(values)


def flat() -> OrderSpectrum:
    orders = np.arange(0.0, 40.0, 0.01)
    return OrderSpectrum(orders, np.ones(len(orders), np.float32), 10.0)


def test_the_largest_amplitude_within_two_bins_of_an_order_is_its_line() -> None:
    found = flat()
    found.amplitude[[0, 502, 3999]] = 90.0, 30.0, 70.0
    assert found.lines([5.0, 5.02, 5.04, 4.99, 5.05]).tolist() == [30.0, 30.0, 30.0, 1.0, 1.0]
    assert found.lines([0.0, 0.02]).tolist() == [1.0, 1.0]  # without the mean
    assert found.lines([500.0]).tolist() == [70.0]  # beyond the end


def test_the_background_is_the_median_from_0_3_orders_to_0_3_beyond_the_last_line() -> None:
    orders = np.arange(0.0, 40.0, 0.01)
    found = OrderSpectrum(orders, orders.astype(np.float32), 1.0)
    for highest in (1.0, 6.7, 20.0):
        assert found.background(highest) == pytest.approx(0.5 * (0.3 + highest + 0.3), abs=0.011)
    assert OrderSpectrum(orders[:20], orders[:20].astype(np.float32), 1.0).background(1.0) == 0.0


@pytest.mark.parametrize(("value", "reference", "expected"), [(8.0, 2.0, 4.0), (1e20, 1e-3, 1e12), (1.0, 0.0, 0.0), (1.0, -1.0, 0.0)])
def test_ratios_are_limited(value: float, reference: float, expected: float) -> None:
    assert ratio(value, reference) == expected


@pytest.mark.parametrize(("value", "expected"), [(100.0, 20.0), (0.5, -3.0103), (0.0, -120.0), (1e13, 120.0), (1e12, 120.0)])
def test_decibels_of_a_ratio_of_squared_amplitudes(value: float, expected: float) -> None:
    assert decibels(value) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("bins", [1000, 1009, 4096])
def test_a_tone_has_its_amplitude_and_its_mean(bins: int) -> None:
    """The mean of a tone over a bin is attenuated by sinc(order / bins per turn), which is made up for."""
    (found,) = order_spectra(np.full((1, bins), 5.0), np.zeros(bins, np.bool_), 50.0)
    length = round(50.0 / found.orders[1])
    assert 2 * bins <= length < 2.1 * bins
    assert len(found.orders) == length // 2 + 1
    order = 2 * (length // 12) * found.orders[1]
    place = (np.arange(bins) + 0.5) / 50.0
    values = 5.0 + 2.0 * np.cos(2.0 * math.pi * order * place) * np.sinc(order / 50.0)
    (found,) = order_spectra(values[None, :], np.zeros(bins, np.bool_), 50.0)
    assert found.mean == pytest.approx(5.0, abs=1e-2)
    assert found.lines([order])[0] == pytest.approx(2.0, rel=5e-3)


def test_without_any_known_bin_there_is_no_spectrum() -> None:
    (found,) = order_spectra(np.full((1, 100), 7.0), np.ones(100, np.bool_), 50.0)
    assert (found.mean, float(found.amplitude.max())) == (0.0, 0.0)


def test_a_spectrum_ends_at_the_highest_order_asked_for() -> None:
    values, known = np.random.default_rng(3).exponential(size=(2, 4000)).astype(np.float32), np.zeros(4000, np.bool_)
    for whole, part in zip(order_spectra(values, known, 50.0), order_spectra(values, known, 50.0, 9.0), strict=True):
        assert part.orders[-1] == pytest.approx(9.0, abs=part.orders[1])
        np.testing.assert_array_equal(part.amplitude, whole.amplitude[: len(part.orders)])
        assert part.mean == whole.mean

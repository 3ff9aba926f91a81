"""Squared envelope spectra of signals whose lines are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, fitted_orders, line_family, median, order_spectra
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
    assert fitted_orders(found, [6.7], 0.004) == pytest.approx(6.71, abs=0.01)
    line = line_family(found, 6.71, np.array([6.71]))
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


def test_line_family_ignores_a_single_line_of_another_origin() -> None:
    orders = np.arange(0.0, 32.0, 0.01)
    amplitude = np.ones(len(orders), np.float32)
    for k in (1, 2, 3):
        amplitude[np.abs(orders - 6.71 * k) < 0.015] = 20.0
    amplitude[np.abs(orders - 6.745) < 0.004] = 300.0  # foreign, within the search
    found = OrderSpectrum(orders, amplitude, 10.0)
    assert fitted_orders(found, [6.7234], 0.004) == pytest.approx(6.71, abs=0.01)
    family = line_family(found, 6.71, np.array([6.71, 13.42, 20.13]))
    assert (family.amplitude, family.depth, family.level) == (20.0, 2.0, pytest.approx(13.0, abs=0.02))


def test_a_silent_signal_has_no_lines() -> None:
    (found,) = order_spectra(np.zeros((1, 4000)), np.zeros(4000, np.bool_), 100)
    assert line_family(found, 6.7, np.array([6.7, 13.4]))[1:] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("length", [1, 2, 3, 15, 400, 4001])
def test_median_equals_that_of_numpy(length: int, kind: type[np.floating]) -> None:
    values = np.random.default_rng(length).standard_normal(length).astype(kind)
    assert median(values) == np.median(values)

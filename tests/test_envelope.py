"""The envelope chain against signals whose envelope is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.envelope import comb_order, line_level, order_spectrum, per_turn, squared_envelope

RATE = 51200
TIME = np.arange(2 * RATE) / RATE
Floats = npt.NDArray[np.float64]
BAND = (2000.0, 20000.0)
INSIDE = slice(400, -400)


def modulated(order: float, angle: Floats, *, depth: float = 0.4, amplitude: float = 3.0) -> Floats:
    """Return a 7 kHz carrier whose amplitude is modulated at an order of the shaft."""
    carrier = np.sin(2.0 * math.pi * 7000.0 * TIME)
    return np.asarray(amplitude * (1.0 + depth * np.cos(order * angle)) * carrier)


def steady(frequency: float) -> Floats:
    """Return the shaft's angle at a steady frequency [Hz]."""
    return np.asarray(2.0 * math.pi * frequency * TIME)


def wrapped(angle: Floats) -> npt.NDArray[np.float32]:
    """Return angles as they come over the wire."""
    return np.mod(angle, 2.0 * math.pi).astype(np.float32)


def test_envelope_of_a_tone_is_its_squared_amplitude() -> None:
    envelope = squared_envelope(5.0 * np.cos(2.0 * math.pi * 6000.0 * TIME), RATE, BAND)
    np.testing.assert_allclose(envelope[INSIDE], 25.0, rtol=1e-9)


def test_envelope_sums_the_axes() -> None:
    tone = np.sin(2.0 * math.pi * 6000.0 * TIME)
    envelope = squared_envelope(np.column_stack([3.0 * tone, 4.0 * tone]), RATE, BAND)
    np.testing.assert_allclose(envelope[INSIDE], 25.0, rtol=1e-9)


@pytest.mark.parametrize("frequency", [0.0, 500.0, 1500.0, 23000.0])
def test_envelope_leaves_out_what_is_outside_the_band(frequency: float) -> None:
    envelope = squared_envelope(100.0 * np.cos(2.0 * math.pi * frequency * TIME), RATE, BAND)
    assert float(envelope.max()) < 1e-12 * 100.0**2


def test_mean_of_the_envelope_is_twice_the_power_in_the_band() -> None:
    noise = np.random.default_rng(1).normal(size=len(TIME))
    envelope = squared_envelope(noise, RATE, BAND)
    # White noise of unit power has 2 (band) / rate of it in the band; the edges of 200 Hz count half each.
    assert float(envelope.mean()) == pytest.approx(2.0 * (18000.0 + 200.0 * 0.75) / (RATE / 2), rel=0.02)


@pytest.mark.parametrize("order", [3.3, 6.71, 9.28])
@pytest.mark.parametrize("frequency", [9.55, 20.0, 30.24])
def test_spectrum_shows_the_order_and_the_amplitude(order: float, frequency: float) -> None:
    angle = steady(frequency)
    envelope = squared_envelope(modulated(order, angle), RATE, BAND)[INSIDE]
    orders, amplitude = order_spectrum(envelope, wrapped(angle)[INSIDE], 32.0)
    peak = int(np.argmax(amplitude[1:])) + 1
    assert orders[peak] == pytest.approx(order, abs=0.5 / (2.0 * frequency))
    # (A (1 + m cos))^2 = A^2 (1 + m^2/2 + 2 m cos + m^2/2 cos 2): 2 m A^2 at the order.
    assert amplitude[peak] == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert amplitude[0] == pytest.approx(9.0 * (1.0 + 0.5 * 0.4**2), rel=0.02)


def test_second_harmonic_of_the_modulation_has_its_closed_form() -> None:
    angle = steady(20.0)
    envelope = squared_envelope(modulated(6.7, angle), RATE, BAND)[INSIDE]
    orders, amplitude = order_spectrum(envelope, wrapped(angle)[INSIDE], 32.0)
    line = line_level(orders, amplitude, 13.4)
    assert line.amplitude == pytest.approx(0.5 * 0.4**2 * 9.0, rel=0.06)


def test_ramp_of_the_speed_does_not_smear_the_order() -> None:
    angle = 2.0 * math.pi * (12.0 * TIME + 6.0 * TIME**2)  # 12 to 36 Hz
    envelope = squared_envelope(modulated(6.71, angle), RATE, BAND)[INSIDE]
    orders, amplitude = order_spectrum(envelope, wrapped(angle)[INSIDE], 32.0)
    line = line_level(orders, amplitude, 6.7)
    assert line.order == pytest.approx(6.71, abs=0.02)
    assert line.amplitude == pytest.approx(2.0 * 0.4 * 9.0, rel=0.06)
    assert line.level > 40.0


@given(frequency=st.floats(4.0, 80.0), bins=st.integers(16, 256))
def test_angle_bins_keep_a_constant(frequency: float, bins: int) -> None:
    values = per_turn(np.full(len(TIME), 7.0), steady(frequency), bins)
    assert len(values) == pytest.approx(2.0 * frequency * bins, abs=2)
    np.testing.assert_allclose(values, 7.0, rtol=1e-9)


def test_line_level_is_the_ratio_to_the_median() -> None:
    orders = np.arange(0.0, 20.0, 0.02)
    amplitude = np.full(len(orders), 2.0)
    amplitude[np.searchsorted(orders, 6.71)] = 200.0
    line = line_level(orders, amplitude, 6.7234)
    assert line.amplitude == 200.0
    assert line.level == pytest.approx(40.0)
    assert line.order == pytest.approx(6.71, abs=0.02)


def test_line_outside_the_search_is_not_taken() -> None:
    orders = np.arange(0.0, 20.0, 0.02)
    amplitude = np.full(len(orders), 2.0)
    amplitude[np.searchsorted(orders, 6.9)] = 200.0  # 2.6 % off
    assert line_level(orders, amplitude, 6.7234).level == pytest.approx(0.0)


def test_line_beyond_the_spectrum_or_in_silence_has_no_level() -> None:
    orders = np.arange(0.0, 20.0, 0.02)
    assert line_level(orders, np.ones(len(orders)), 30.0) == (30.0, 0.0, 0.0)
    assert line_level(orders, np.zeros(len(orders)), 5.0).level == 0.0


def test_comb_follows_the_family_and_not_a_foreign_line() -> None:
    orders = np.arange(0.0, 32.0, 0.01)
    amplitude = np.full(len(orders), 1.0)
    for k in (1, 2, 3):
        amplitude[np.abs(orders - 6.71 * k) < 0.03] = 20.0
    amplitude[np.abs(orders - 6.80) < 0.01] = 300.0  # foreign, within the search
    assert comb_order(orders, amplitude, 6.7234) == pytest.approx(6.71, abs=0.02)

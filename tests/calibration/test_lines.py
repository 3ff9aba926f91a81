"""Lines of mains and shaft, the fluctuation of a speed and the background, each in a signal with known values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.calibration.estimate import QUANTILE, by_difference, by_factor
from dcrb_ros.calibration.identified_path import IdentifiedPath, Part
from dcrb_ros.calibration.lines import mains_hum, order_line, shaft_modulation, speed_fluctuation, without_lines
from dcrb_ros.calibration.speed_and_background import Excess, _add_background, _heard_band, _pink_noise
from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.schema.arrays import Floats

RATE, SECONDS, SHAFT = 8192, 10.0, 23.0
"""Sampling rate [Hz], length [s] and frequency of the shaft [Hz]."""
TIME = np.arange(round(RATE * SECONDS)) / RATE
TURNS = SHAFT * TIME


def noise(seed: int, deviation: float = 1.0) -> Floats:
    return np.asarray(deviation * np.random.default_rng(seed).standard_normal(len(TIME)))


@pytest.mark.parametrize("mains", [50.0, 60.0, 50.0 / 3.0])
def test_hum_has_its_amplitude_and_frequency(mains: float) -> None:
    hum, reason = mains_hum(0.3 * np.sin(2.0 * np.pi * 1.001 * mains * TIME) + noise(1, 0.1), RATE, SHAFT)
    assert hum is not None
    assert reason == ""
    assert hum.level == pytest.approx(0.3, abs=4.0 * hum.error)
    assert hum.error == pytest.approx(0.1 * math.sqrt(2.0 / len(TIME)), rel=0.15)
    assert hum.frequency == pytest.approx(1.001 * mains, abs=0.01)


def test_a_line_at_a_harmonic_of_the_shaft_is_no_hum() -> None:
    hum, reason = mains_hum(np.sin(2.0 * np.pi * 50.0 * TIME) + noise(1, 0.1), RATE, 25.0)
    assert hum is None
    assert "order 2 of the shaft" in reason


def test_a_line_of_the_shaft_has_its_amplitude_and_the_error_of_the_noise() -> None:
    lines = [order_line(0.2 * np.cos(2.0 * np.pi * TURNS + 0.7) + noise(seed), TURNS, 1.0) for seed in range(40)]
    values = np.array([line for line, _ in lines])
    assert abs(values.mean()) == pytest.approx(0.2, rel=0.05)
    assert np.angle(values.mean()) == pytest.approx(0.7, abs=0.05)
    # The error is that of the real or of the imaginary part.
    assert np.mean([error for _, error in lines]) == pytest.approx(math.sqrt(0.5 * np.mean(np.abs(values - values.mean()) ** 2)), rel=0.2)


def test_harmonics_of_shaft_and_mains_are_taken_out() -> None:
    rest = noise(3)
    lines = np.sin(2.0 * np.pi * 5.0 * TURNS) + np.cos(2.0 * np.pi * 150.0 * TIME)
    cleaned = without_lines(rest + lines, TURNS, RATE, 50.0)
    assert np.std(cleaned - rest) < 0.02
    assert np.std(without_lines(rest + lines, TURNS, RATE, 0.0) - rest) == pytest.approx(math.sqrt(0.5), rel=0.02)


def test_ripple_and_slow_fluctuation_of_a_speed_are_separated() -> None:
    slow, ripple = 2e-3 * np.sin(2.0 * np.pi * 1.3 * TIME), 1e-3 * np.sin(2.0 * np.pi * TURNS)
    turns = np.cumsum(SHAFT * (1.0 + slow + ripple)) / RATE
    found = speed_fluctuation(turns, RATE)
    assert found.random == pytest.approx(2e-3 / math.sqrt(2.0), rel=0.05)
    assert found.ripple == pytest.approx(1e-3 / math.sqrt(2.0), rel=0.05)
    assert found.random_error == pytest.approx(found.random / math.sqrt(2.0 * SECONDS), rel=1e-3)


@pytest.mark.parametrize("depth", [0.1, 0.4])
def test_noise_modulated_by_the_shaft_has_the_depth_of_the_formula_and_an_error_like_its_scatter(depth: float) -> None:
    modulation = 1.0 + depth * np.cos(2.0 * np.pi * TURNS)
    lines = [shaft_modulation(noise(seed) * modulation, TURNS, RATE, 500.0, 3000.0) for seed in range(20)]
    depths, errors = np.array(lines).T
    assert depths.mean() == pytest.approx(2.0 * depth / (1.0 + 0.5 * depth**2), rel=0.03)
    # It is that of the noise around the line, up to 1.4 times the scatter of its depth.
    assert 0.9 * depths.std() < np.mean(errors) < 1.7 * depths.std()


def test_the_noise_of_an_envelope_is_no_modulation() -> None:
    lines = [shaft_modulation(noise(seed), TURNS, RATE, 500.0, 3000.0) for seed in range(20)]
    assert [depth for depth, _ in lines].count(0.0) >= 10  # the line is below the noise around it in most cases
    assert max(depth / error for depth, error in lines) < 3.0


def excess(axis: str, density: Floats, frequency: Floats) -> Excess:
    return Excess(axis, frequency, density, np.ones(len(frequency), bool))


@pytest.mark.parametrize("bins", [0, 3, 8])
def test_less_than_an_octave_has_no_band_of_the_bearing(bins: int) -> None:
    assert _heard_band(np.linspace(400.0, 420.0, bins), np.ones(bins)) is None


def test_pink_noise_is_named_by_its_density_at_1_hz() -> None:
    frequency = np.geomspace(5.0, 200.0, 100)
    found = _pink_noise([excess(axis, (300.0 * MICRO_G) ** 2 / frequency, frequency) for axis in "xy"])
    assert found is not None
    assert found.value == pytest.approx(300.0, rel=1e-6)
    assert _pink_noise([excess("x", np.full(100, 1e-3), frequency)]) is None


def test_a_background_is_that_of_the_machine_at_the_reference_speed() -> None:
    """White noise of 2 (m/s^2)^2/Hz from 5 to 205 Hz behind a gain of 2, at half the reference speed of 20 m/s."""
    frequency, part = np.linspace(5.0, 205.0, 401), Part()
    path = IdentifiedPath(parameters={"structure.gain_x": 2.0, "structure.gain_y": 2.0})
    _add_background(part, [excess(axis, np.full(401, 2.0), frequency) for axis in "xy"], path, 10.0)
    assert part.parameters["background.track_level"] == pytest.approx(2.0 * math.sqrt(2.0 * 200.0) / 2.0, rel=0.01)
    assert part.parameters["background.track_low"] == pytest.approx(15.0, abs=1.0)
    assert part.parameters["background.track_high"] == pytest.approx(195.0, abs=1.0)


def test_intervals_are_those_of_a_normal_variable() -> None:
    factor, difference = by_factor("k", 3.0, 0.2, "-"), by_difference("k", 3.0, 0.2, "-")
    assert (factor.low, factor.high) == pytest.approx((3.0 / math.exp(0.2 * QUANTILE), 3.0 * math.exp(0.2 * QUANTILE)))
    assert (difference.low, difference.high) == pytest.approx((3.0 - 0.2 * QUANTILE, 3.0 + 0.2 * QUANTILE))
    assert by_difference("k", 0.1, 0.2, "-").low == 0.0

"""The noise of the machine beside its bearing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import sosfreqz, welch

from dcrb_ros import Refusal, load_configuration
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.machine_noise import MachineNoise
from dcrb_ros.measurement.stages.path import cascade, pairs
from dcrb_ros.schema.arrays import Floats

RATE = 51200.0


def noise(**structure: object) -> MachineNoise:
    """Return the stage with parameters of the group structure."""
    return MachineNoise(load_configuration("dry", {f"structure.{key}": value for key, value in structure.items()}).measurement, RATE)


def span(first: int, samples: int) -> Span:
    """Return a span at 20 Hz of the shaft."""
    return Span(first, 2.0 * math.pi * 20.0 * (first - 1 + np.arange(samples + 1)) / RATE)


def test_it_has_the_density_of_its_sections_and_the_share_of_the_rest() -> None:
    path = "2000 0.05 3000 0.05"
    found = noise(bearing_share=0.25, noise_x=0.3, noise_y=0.1, noise_path_y=path).process(np.zeros((400000, 2)), span(0, 400000))
    frequency, density = welch(found[20000:], RATE, nperseg=1024, axis=0)
    used = (frequency > 200.0) & (frequency < 20000.0)
    response = np.abs(sosfreqz(cascade(pairs(path, ""), RATE), frequency[used], fs=RATE)[1])
    assert np.sqrt(density[used, 0].mean()) == pytest.approx(0.3 * math.sqrt(0.75), rel=0.01)
    level = 10.0 * np.log10(density[used, 1] / (0.75 * (0.1 * response) ** 2))
    assert np.sqrt(np.mean(level**2)) < 0.5
    assert abs(np.corrcoef(found.T)[0, 1]) < 0.02


def test_the_bearing_keeps_its_share_of_the_power() -> None:
    tone = np.sin(np.arange(1000))[:, None] * np.ones(2)
    assert noise(bearing_share=0.25, noise_x=1e-15).process(tone, span(0, 1000)) == pytest.approx(0.5 * tone, abs=1e-11)
    with pytest.raises(Refusal, match=r"bearing_share = 0\.25 leaves the rest to noise of the machine, which has no level: give"):
        noise(bearing_share=0.25)


def test_noise_of_the_same_power_leaves_the_power_at_any_share() -> None:
    bearing: Floats = np.random.default_rng(1).standard_normal((200000, 2))
    density = math.sqrt(2.0 / RATE)
    for share in (0.01, 0.5, 0.99):
        found = noise(bearing_share=share, noise_x=density, noise_y=density).process(bearing, span(0, len(bearing)))
        assert found.std() == pytest.approx(1.0, rel=0.01)


def test_the_shaft_modulates_it_like_the_bearing() -> None:
    found = noise(bearing_share=1e-6, noise_x=1.0, noise_y=1.0, modulation=0.6).process(np.zeros((409600, 2)), span(0, 409600))
    squared = (found[:, 1] ** 2).reshape(-1, 2560).mean(axis=0)  # over a turn
    line = 2.0 * abs(np.fft.rfft(squared)[1]) / squared.sum()
    assert line == pytest.approx(2.0 * 0.6 / (1.0 + 0.5 * 0.6**2), rel=0.03)


def test_the_samples_do_not_depend_on_the_blocks() -> None:
    parameters = {"bearing_share": 0.5, "noise_y": 1.0, "noise_path_y": "900 0.1 2000 0.1", "modulation": 0.3}
    whole, parts = noise(**parameters), noise(**parameters)
    at_once = whole.process(np.ones((1000, 2)), span(0, 1000))
    pieces = [parts.process(np.ones((300, 2)), span(0, 300)), parts.process(np.ones((700, 2)), span(300, 700))]
    assert np.array_equal(at_once, np.concatenate(pieces))


def test_a_share_of_one_is_off_and_bad_sections_are_refused() -> None:
    assert not noise(noise_y=1.0).active
    with pytest.raises(Refusal, match=r"structure.noise_path_y: '1400 0.03' is not a pair"):
        noise(noise_path_y="1400 0.03")
    with pytest.raises(Refusal, match="give a share, not per cent"):
        noise(bearing_share=30.0)

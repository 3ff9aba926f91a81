"""A line whose frequency wanders: noise has no hump, a wandering tone has one as deep as the tone, sharp lines have none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.diagnosis.line_search import NO_LINES, LineFamily
from dcrb_ros.diagnosis.order_spectrum import order_spectra
from dcrb_ros.diagnosis.wandering_lines import humps
from dcrb_ros.schema.arrays import Floats

FTF, MIDDLE, BINS = 0.4, 4.7, 48
"""A bearing like a 6205, with bins per turn."""


def found(envelope: Floats, slip: float = 0.02) -> LineFamily:
    """Return the hump in a squared envelope with `BINS` values per turn."""
    (spectrum,) = order_spectra(envelope[None], np.zeros(len(envelope), np.bool_), BINS)
    depth = np.square(spectrum.amplitude / spectrum.mean)
    return humps(depth[None], float(spectrum.orders[1]), MIDDLE, FTF, slip)[0]


def noise(turns: int, random: np.random.Generator) -> Floats:
    """Return the squared envelope of noise."""
    return np.asarray(random.exponential(size=turns * BINS), np.float64)


def tone(turns: int, random: np.random.Generator, depth: float, memory: float) -> Floats:
    """Return a tone of unit mean at `MIDDLE` whose phase diffuses by one radian within ``memory`` [turns]."""
    steps = random.normal(0.0, 1.0 / math.sqrt(memory * BINS), turns * BINS)
    turn = np.arange(turns * BINS) / BINS
    return np.asarray(1.0 + depth * np.cos(2.0 * np.pi * MIDDLE * turn + np.cumsum(steps)), np.float64)


@pytest.mark.parametrize("turns", [120, 300])
@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_noise_has_humps_no_more_often_than_stated(turns: int, colour: float) -> None:
    """White noise and noise whose spectrum falls over the order; the middles and widths overlap, so that the true rate is lower."""
    random, count = np.random.default_rng(4), 1500
    significance = []
    for _ in range(count):
        envelope = noise(turns, random)
        if colour:
            envelope[1:] += colour * envelope[:-1]
        significance.append(found(envelope).significance)
    for stated in (1.0, 2.0):
        assert np.mean(np.array(significance) > stated) < 1.3 * 10.0**-stated + 3.0 * math.sqrt(10.0**-stated / count)


@pytest.mark.parametrize("memory", [4.0, 8.0])
def test_a_wandering_line_has_a_depth_in_proportion_to_that_of_a_steady_one(memory: float) -> None:
    """A phase that diffuses makes a Lorentzian hump 1 / (2 pi memory) orders wide, whose median is below its mean."""
    random = np.random.default_rng(7)

    def humps(depth: float) -> list[LineFamily]:
        return [found(tone(300, random, depth, memory) + 0.1 * noise(300, random)) for _ in range(30)]

    strong, weak = humps(0.8), humps(0.4)
    assert np.mean([one.significance > 6.0 for one in strong]) > 0.9
    assert np.mean([one.order for one in strong]) == pytest.approx(MIDDLE, rel=0.01)
    depths = [float(np.mean([one.depth for one in each])) for each in (strong, weak)]
    assert 0.4 * 0.8 / 1.1 < depths[0] < 0.8 / 1.1
    assert depths[0] / depths[1] == pytest.approx(2.0, rel=0.15)


def test_sharp_lines_are_no_hump() -> None:
    """Lines of rings and shaft beside 2 BSF, and one at 2 BSF itself, far above the noise."""
    random = np.random.default_rng(2)
    turn = np.arange(300 * BINS) / BINS
    lines = sum(0.5 * np.cos(2.0 * np.pi * order * turn) for order in (3.585, 4.0, 4.415, 4.585, MIDDLE, 5.0, 5.415, 6.0))
    assert found(noise(300, random) + lines).significance < 3.0


def test_a_short_spectrum_has_no_hump() -> None:
    """A window of 12 turns has 20 values in the widest hump, of which six are independent."""
    assert found(tone(12, np.random.default_rng(1), 0.8, 4.0)) == NO_LINES
    assert humps(np.ones((2, 100)), 0.01, MIDDLE, FTF, 0.02) == [NO_LINES] * 2
    assert humps(np.ones((2, 5000)), 0.01, 1.5, FTF, 0.02) == [NO_LINES] * 2

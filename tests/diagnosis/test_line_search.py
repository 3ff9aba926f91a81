"""The search for families of lines: its false alarms have the stated probability, and it finds what is there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.evidence import SharedSearch
from dcrb_ros.diagnosis.line_search import LARGEST_SCORE, Comb, LineSearch, covered, local_mean, log10_gamma_tail
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, order_spectra

BINS = 80
COMBS = [
    Comb(3.58),
    Comb(5.42, sidebands=(-1.0, 0.0, 1.0)),
    Comb(4.71, sidebands=(-0.4, 0.0, 0.4)),
    Comb(0.398, tuple(range(1, 7)), leading=2),
]


def spectrum(envelope: np.ndarray) -> OrderSpectrum:
    """Return the spectrum of a squared envelope with 80 bins per turn."""
    (found,) = order_spectra(envelope[None, :], np.zeros(len(envelope), np.bool_), BINS)
    return found


def noise(seed: int, turns: int, colour: float = 0.0) -> np.ndarray:
    """Return the squared envelope of Gaussian noise, whose level wanders if it is coloured."""
    random = np.random.default_rng(seed)
    envelope = random.exponential(1.0, turns * BINS)
    if colour:
        slow = np.convolve(random.normal(size=turns * BINS), np.exp(-np.arange(BINS) / 12.0), "same")
        envelope *= np.exp(colour * slow / slow.std())
    return envelope


@pytest.mark.parametrize("colour", [0.0, 0.5])
@pytest.mark.parametrize("turns", [20, 80])
@pytest.mark.parametrize("comb", COMBS, ids=["outer", "inner", "roller", "cage"])
def test_noise_is_significant_no_more_often_than_stated(comb: Comb, turns: int, colour: float) -> None:
    """The probability of a false alarm is an upper bound: Bonferroni counts neighbouring places as independent."""
    runs = 200
    found = np.array([LineSearch(spectrum(noise(seed, turns, colour))).best(comb, 0.02).significance for seed in range(runs)])
    for level in (1.0, 2.0):
        alarms = int(np.count_nonzero(found >= level))
        assert stats.binom.sf(alarms - 1, runs, 10.0**-level) > 1e-3, (level, alarms)


def test_the_harmonics_of_the_shaft_are_no_evidence() -> None:
    place = np.arange(100 * BINS) / BINS
    envelope = noise(1, 100) + sum(np.cos(2.0 * np.pi * k * place) for k in range(1, 13))
    found = LineSearch(spectrum(envelope)).best(Comb(3.98), 0.02)
    assert found.depth < 0.1


@pytest.mark.parametrize("departure", [-0.018, -0.004, 0.0, 0.009, 0.019])
@pytest.mark.parametrize("comb", COMBS[:2], ids=["outer", "inner"])
def test_a_family_is_found_where_it_is(comb: Comb, departure: float) -> None:
    place = np.arange(100 * BINS) / BINS
    order = comb.order * (1.0 + departure)
    envelope = noise(2, 100) + sum(0.5 * np.cos(2.0 * np.pi * h * order * place) for h in (1, 2, 3))
    found = LineSearch(spectrum(envelope)).best(comb, 0.02)
    assert found.order == pytest.approx(order, rel=1e-3)
    assert found.depth == pytest.approx(0.5, rel=0.2)
    assert found.significance > 6.0
    assert found.lines == pytest.approx([order, 2.0 * order, 3.0 * order], rel=1e-3)


def test_the_slope_of_a_line_beyond_the_range_is_no_family() -> None:
    place = np.arange(40 * BINS) / BINS
    envelope = noise(3, 40) + sum(3.0 * np.cos(2.0 * np.pi * h * 3.58 * 1.024 * place) for h in (1, 2, 3)) + 9.0
    assert LineSearch(spectrum(envelope)).best(Comb(3.58), 0.02).depth < 0.1


def test_no_single_line_makes_a_family() -> None:
    place = np.arange(100 * BINS) / BINS
    for harmonic in (1, 2, 3):
        envelope = noise(4, 100) + 2.0 * np.cos(2.0 * np.pi * harmonic * 3.58 * place) + 2.0
        assert LineSearch(spectrum(envelope)).best(Comb(3.58), 0.02).significance < 4.0
        if harmonic > 1:  # a line at a multiple of the fundamental counts no more than the fundamental
            assert LineSearch(spectrum(envelope)).best(Comb(3.58), 0.02).depth < 0.1


@pytest.mark.parametrize("gain", [1e-4, 1e4])
def test_no_gain_changes_depth_or_significance(gain: float) -> None:
    place = np.arange(60 * BINS) / BINS
    envelope = noise(5, 60) + 0.4 * np.cos(2.0 * np.pi * 3.6 * place) + 0.2 * np.cos(4.0 * np.pi * 3.6 * place)
    one, other = (LineSearch(spectrum(factor * envelope)).best(Comb(3.58), 0.02) for factor in (1.0, gain))
    assert (other.depth, other.significance, other.level) == pytest.approx((one.depth, one.significance, one.level), rel=1e-3)
    assert other.amplitude == pytest.approx(gain * one.amplitude, rel=1e-3)


def test_left_out_lines_are_no_evidence() -> None:
    place = np.arange(100 * BINS) / BINS
    found = spectrum(noise(6, 100) + sum(0.5 * np.cos(2.0 * np.pi * h * 3.6 * place) for h in (1, 2, 3)))
    without = covered(found, [3.6, 7.2, 10.8])
    assert np.count_nonzero(without) == 3 * 9
    assert LineSearch(found, without=without).best(Comb(3.6), 0.003).depth < 0.1


@pytest.mark.parametrize("count", [1, 3, 9, 13])
@pytest.mark.parametrize("total", [0.5, 5.0, 40.0, 13 * LARGEST_SCORE])
def test_the_tail_of_a_sum_of_exponential_variables(total: float, count: int) -> None:
    assert log10_gamma_tail(total, count) == pytest.approx(stats.gamma.logsf(total, count) / np.log(10.0), abs=1e-9)
    assert log10_gamma_tail(0.0, count) == 0.0


def test_the_local_mean_follows_the_noise_and_ignores_lines() -> None:
    level = np.exp(-np.arange(8000) / 3000.0)
    power = level * np.random.default_rng(7).exponential(size=8000)
    power[::40] += 1e3
    found = local_mean(power, 400)
    assert np.abs(np.log(found / level))[200:-200].max() < 0.4
    assert np.ptp(local_mean(power[:50], 400)) == 0.0


def test_a_family_above_the_spectrum_has_no_lines() -> None:
    assert LineSearch(spectrum(noise(8, 30))).best(Comb(100.0), 0.02).depth == 0.0


def test_what_lies_above_the_families_changes_none() -> None:
    """Only the part of a spectrum is searched in which families have lines."""
    orders = Orders(0.4, 3.6, 5.4, 2.4)
    whole = spectrum(noise(6, 60, colour=0.5))
    shared = SharedSearch([whole], orders, 0.02)
    assert len(shared.search.orders) < 0.75 * len(whole.orders)
    for comb in (Comb(3.6), Comb(7.2), Comb(5.4, sidebands=(-1.0, 0.0, 1.0)), Comb(4.8, sidebands=(-0.4, 0.0, 0.4)), Comb(0.4, (1, 2, 3))):
        assert shared.families(comb) == LineSearch(whole).families(comb, 0.02)


def test_spectra_that_are_searched_together_have_the_families_of_each_alone() -> None:
    place = np.arange(60 * BINS) / BINS
    lines = 0.5 * np.cos(2.0 * np.pi * 3.62 * place) + 0.4 * np.cos(4.0 * np.pi * 3.62 * place)
    spectra = [spectrum(gain * (noise(seed, 60, colour=0.3) + lines * (seed % 2))) for seed, gain in ((11, 1.0), (12, 1e-3), (13, 1e3))]
    together = LineSearch(*spectra)
    for comb in COMBS:
        assert together.families(comb, 0.02) == [LineSearch(one).best(comb, 0.02) for one in spectra]
    places = np.array([3.62, 7.24, 5.0, 1e3])
    for number, one in enumerate(spectra):
        assert together.at(places, number).tolist() == LineSearch(one).at(places).tolist()


@pytest.mark.parametrize("sidebands", [(0.0,), (-1.0, 0.0, 1.0)])
def test_families_with_and_without_sidebands_are_compared_by_line(sidebands: tuple[float, ...]) -> None:
    """Lines of 0.3 each: together they have 0.3 times the root of their number."""
    orders = np.arange(0.0, 40.0, 0.01)
    amplitude = np.full(len(orders), 1e-3, np.float32)
    amplitude[[round(100.0 * (5.4 + side)) for side in sidebands]] = 0.3
    found = LineSearch(OrderSpectrum(orders, amplitude, 1.0)).best(Comb(5.4, (1,), sidebands), 0.004)
    assert found.depth == pytest.approx(0.3 * math.sqrt(len(sidebands)), rel=1e-3)
    assert found.depth_per_line == pytest.approx(0.3, rel=1e-3)


def test_a_spectrum_without_signal_has_no_lines() -> None:
    silent = spectrum(np.zeros(30 * BINS))
    loud = spectrum(noise(14, 30))
    for found in (LineSearch(silent).best(COMBS[0], 0.02), LineSearch(loud, silent).families(COMBS[0], 0.02)[1]):
        assert (found.amplitude, found.depth, found.level) == (0.0, 0.0, 0.0)
        assert found.significance < 0.0

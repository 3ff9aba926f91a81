"""Estimated shaft speed, on spectra with lines of known levels."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.speed_estimation import estimated_frequency, line_orders

ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)


def spectrum(lines: list[float], level: float) -> OrderSpectrum:
    """Return a spectrum over frequencies [Hz] of background 1, with lines of a level [dB]."""
    frequencies = np.arange(0.0, 2000.0, 0.05)
    amplitude = np.ones(len(frequencies), np.float32)
    for line in lines:
        amplitude[round(line / 0.05) + np.arange(-5, 6)] = 10.0 ** (level / 10.0)
    return OrderSpectrum(frequencies, amplitude, 10.0)


def test_the_families_are_bpfo_bpfi_and_twice_bsf_with_sidebands() -> None:
    outer, inner, roller = line_orders(ORDERS)
    assert outer.tolist() == pytest.approx([6.72, 13.44, 20.16, 26.88])
    assert inner.tolist() == pytest.approx([k * 9.28 + s for k in (1, 2, 3) for s in (-2, -1, 0, 1, 2)])
    assert roller.tolist() == pytest.approx([k * 6.1 + s * 0.42 for k in (1, 2, 3) for s in (-2, -1, 0, 1, 2)])


@pytest.mark.parametrize(("level", "counted"), [(20.0, 20.0), (50.0, 30.0)])
@pytest.mark.parametrize("family", [0, 1, 2])
def test_the_score_is_the_sum_of_limited_levels_over_the_root_of_their_number(family: int, level: float, counted: float) -> None:
    lines = line_orders(ORDERS)[family]
    found = estimated_frequency([spectrum((23.0 * lines).tolist(), level)], 1.0, ORDERS, 10.0, 40.0)
    assert found.frequency == pytest.approx(23.0, rel=1e-3)
    assert found.score == pytest.approx(counted * np.sqrt(len(lines)), rel=0.02)
    assert 0.0 < found.rival < 0.9


def test_the_scores_of_several_spectra_add_up() -> None:
    one, other = (spectrum((23.0 * line_orders(ORDERS)[family]).tolist(), 20.0) for family in (0, 1))
    silent = OrderSpectrum(one.orders, np.zeros(len(one.orders), np.float32), 0.0)
    scores = [estimated_frequency(spectra, 1.0, ORDERS, 20.0, 26.0).score for spectra in ([one], [other], [one, other, silent])]
    assert scores[2] == pytest.approx(scores[0] + scores[1], rel=0.02)


def test_the_range_of_speeds_is_tried_in_steps_of_a_two_thousandth() -> None:
    lines = (23.0 * line_orders(ORDERS)[0]).tolist()
    assert estimated_frequency([spectrum(lines, 20.0)], 1.0, ORDERS, 23.0, 40.0).frequency == pytest.approx(23.0, rel=1e-9)
    assert estimated_frequency([spectrum(lines, 20.0)], 1.0, ORDERS, 10.0, 22.0).frequency < 22.0
    steps = [estimated_frequency([spectrum([], 0.0)], 1.0, ORDERS, 10.0, 10.0 * np.exp(width)).rival for width in (0.0199, 0.1)]
    assert steps == [0.0, 0.0]
    scaled = OrderSpectrum(spectrum(lines, 20.0).orders / 70.0, spectrum(lines, 20.0).amplitude, 10.0)
    assert estimated_frequency([scaled], 70.0, ORDERS, 10.0, 40.0).frequency == pytest.approx(23.0, rel=1e-3)


def test_a_rival_differs_by_more_than_two_per_cent() -> None:
    near, far = (spectrum([*(23.0 * line_orders(ORDERS)[0]), *(other * line_orders(ORDERS)[0])], 20.0) for other in (23.4, 23.6))
    assert estimated_frequency([near], 1.0, ORDERS, 22.8, 23.8).rival < 0.5
    assert estimated_frequency([far], 1.0, ORDERS, 22.8, 23.8).rival == pytest.approx(1.0, abs=0.05)

"""Which of two boxes has the impacts first, on squared envelopes that are known."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic_bearing import TURN

from dcrb_ros.diagnosis.vehicle.arrival import TurnEnvelopes, lead

BINS, FREQUENCY, ORDER = 170, 20.0, 6.74
ORDERS = ORDER * np.array([1.0, 2.0, 3.0])


def envelopes(late: float, seed: int, noise: float = 0.3, begin: float = -60.0) -> TurnEnvelopes:
    """Return the envelopes of impacts that are late [s] from an angle ``begin`` [turns] on, in three bands of different level."""
    turns = begin + np.arange(round(-begin * BINS)) / BINS - late * FREQUENCY
    impacts = 1.0 + sum(np.cos(TURN * order * turns) for order in ORDERS)
    random = np.random.default_rng(seed).exponential(noise, (3, len(turns)))
    return TurnEnvelopes((np.array([[1.0], [30.0], [0.1]]) * (impacts + random)).astype(np.float32), BINS, begin)


@pytest.mark.parametrize("late", [0.9e-3, -0.9e-3, 2.2e-3, 0.0])
def test_the_lead_is_the_delay_of_the_other_box(late: float) -> None:
    assert lead(envelopes(0.0, 1), envelopes(late, 2), ORDERS, FREQUENCY) == pytest.approx(late, abs=1e-4)


@pytest.mark.parametrize("later", [-0.9, -0.4, 0.4, 0.9])
def test_bins_may_begin_at_another_angle(later: float) -> None:
    """By a part of a bin, which takes 0.29 ms; a window then has one bin more or less."""
    other = envelopes(0.9e-3, 2, begin=-60.0 + later / BINS)
    assert lead(envelopes(0.0, 1), other, ORDERS, FREQUENCY) == pytest.approx(0.9e-3, abs=1e-4)


def test_bands_of_opposite_phase_agree_with_no_delay() -> None:
    own = envelopes(0.0, 1)
    turned = 2.0 * own.values.mean(axis=1, keepdims=True) - own.values
    other = own._replace(values=np.array([own.values[0], turned[1], 1.0 + 0.0 * own.values[2]], np.float32))
    assert lead(own, other, ORDERS, FREQUENCY) == 0.0


def test_half_of_the_lines_must_agree_with_a_delay() -> None:
    """With one of three bands in opposite phase a third of the lines is left; a silent band has no lines."""
    own, late = envelopes(0.0, 1), envelopes(0.9e-3, 2).values
    for third, expected in ((2.0 * late[1].mean() - late[1], 0.0), (np.ones_like(late[1]), 0.9e-3)):
        other = own._replace(values=np.array([late[0], third, late[2]], np.float32))
        assert lead(own, other, ORDERS, FREQUENCY) == pytest.approx(expected, abs=1e-4)


def test_windows_of_another_length_are_not_compared() -> None:
    own = envelopes(0.0, 1)
    assert lead(own, own._replace(values=own.values[:, :-5]), ORDERS, FREQUENCY) == 0.0


def test_lines_of_a_cage_are_too_slow() -> None:
    assert lead(envelopes(0.0, 1), envelopes(2.0e-3, 2), ORDERS, 0.1 * FREQUENCY) == 0.0

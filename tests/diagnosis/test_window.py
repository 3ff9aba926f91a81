"""The sliding window: squared envelopes over the angle of the shaft."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.diagnosis.window import LARGEST, Hop, Window, _missing_bins, margin_samples

RATE, HOP, MARGIN, BINS = 12800, 6400, 128, 60
LENGTH = HOP + 2 * MARGIN


def window(*, hops: int = 3, exponent: float = 1.0) -> Window:
    return Window(Demodulator((Band(1000.0, 4000.0),), RATE, LENGTH), RATE, HOP, MARGIN, BINS, hops, exponent)


def segment(
    number: int, turns: npt.NDArray[np.float64] | None, *, amplitude: float = 3.0, missing: npt.NDArray[np.bool_] | None = None
) -> Segment:
    """Return a tone at 2 kHz, whose squared envelope is the square of its amplitude."""
    samples = amplitude * np.cos(2.0 * math.pi * 2000.0 * np.arange(LENGTH) / RATE)
    lost = np.zeros(LENGTH, np.bool_) if missing is None else missing
    return Segment(HOP * (number + 1), np.column_stack([samples, np.zeros(LENGTH)]), turns, lost, 0, number == 0)


def turning(frequency: float) -> npt.NDArray[np.float64]:
    return frequency * np.arange(LENGTH) / RATE


@pytest.mark.parametrize("frequency", [10.0, -10.0, 33.3])
@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_envelopes_are_scaled_to_twenty_hertz(frequency: float, exponent: float) -> None:
    made = window(exponent=exponent)
    hop = made.add(segment(0, turning(frequency)), 70.0, useless=False)
    assert hop is not None
    assert hop.turns == pytest.approx(abs(frequency) * 0.5, rel=1e-3)
    assert hop.envelopes.shape == (1, pytest.approx(abs(frequency) * 0.5 * BINS, abs=1))
    assert np.median(hop.envelopes) == pytest.approx(9.0 * (20.0 / abs(frequency)) ** (2.0 * exponent), rel=1e-3)
    assert hop.powers == pytest.approx(9.0 * (20.0 / abs(frequency)) ** (2.0 * exponent), rel=1e-2)
    assert (made.tracked, made.missing_share, len(made)) == (True, 0.0, 1)
    assert made.frequency == pytest.approx(abs(frequency))


@pytest.mark.parametrize("frequency", [10.0, -33.3])
def test_the_first_bin_begins_before_the_turns_of_the_window(frequency: float) -> None:
    made = window()
    for number in range(5):
        made.add(segment(number, turning(frequency)), 70.0, useless=False)
    assert -1.0 / BINS - 1e-9 < made.begin + made.turns < 1e-9


def test_a_shaft_slower_than_half_a_hertz_is_scaled_as_at_half_a_hertz() -> None:
    hop = window().add(segment(0, turning(0.25)), 70.0, useless=False)
    assert hop is not None
    assert np.median(hop.envelopes) == pytest.approx(9.0 * 40.0**2, rel=1e-3)


def test_without_an_angle_the_clock_turns_and_nothing_is_scaled() -> None:
    made = window()
    hop = made.add(segment(0, None), 70.0, useless=False)
    assert hop is not None
    assert not made.tracked
    assert made.frequency == pytest.approx(70.0)
    assert np.median(hop.envelopes) == pytest.approx(9.0, rel=1e-3)


def test_the_window_holds_the_latest_hops() -> None:
    made = window(hops=3)
    for number in range(5):
        made.add(segment(number, turning(10.0)), 70.0, useless=number == 4)
        assert len(made) == min(3, number + 1)
    assert made.turns == pytest.approx(15.0)
    assert made.missing_share == pytest.approx(1.0 / 3.0, abs=0.01)
    envelopes, missing = made.envelopes()
    assert envelopes.shape == (1, len(missing))
    assert len(missing) == pytest.approx(900, abs=2)
    made.clear()
    assert (len(made), made.turns, made.frequency, made.missing_share) == (0, 0.0, 0.0, 1.0)


def test_a_reversal_starts_a_new_window_and_jitter_does_not() -> None:
    made, back = window(), turning(10.0).copy()
    middle = MARGIN + HOP // 2
    made.add(segment(0, turning(10.0)), 70.0, useless=False)
    back[middle:] = back[middle] - (back[middle:] - back[middle])
    assert made.add(segment(1, back), 70.0, useless=False) is None
    assert (made.reversed, len(made)) == (True, 0)
    made.add(segment(2, turning(-10.0)), 70.0, useless=False)
    assert (made.reversed, len(made)) == (False, 1)
    jitter = turning(-10.0) + np.where(np.arange(LENGTH) % 100 == 0, 0.015, 0.0)
    made.add(segment(3, jitter), 70.0, useless=False)
    assert len(made) == 2
    made.add(segment(4, turning(10.0)), 70.0, useless=False)  # the other direction
    assert len(made) == 1
    made.add(segment(5, turning(0.02)), 70.0, useless=False)  # a hundredth of a turn has no direction
    assert len(made) == 2
    made.add(segment(6, None), 70.0, useless=False)
    assert len(made) == 1


@pytest.mark.parametrize("frequency", [10.0, -10.0])
def test_a_shaft_that_starts_from_rest_keeps_its_window(frequency: float) -> None:
    made = window()
    for number, speed in enumerate((0.02, frequency)):  # a hundredth of a turn has no direction
        made.add(segment(number, turning(speed)), 70.0, useless=False)
    assert len(made) == 2


@given(missing=st.lists(st.booleans(), min_size=40, max_size=40), beside=st.integers(0, 5), begin=st.floats(0.0, 8.0))
def test_a_bin_is_missing_with_any_sample_in_it_or_beside_it(missing: list[bool], beside: int, begin: float) -> None:
    positions = begin + 3.7 * np.arange(9)
    lost = np.array(missing)
    found = _missing_bins(lost, positions, beside)
    for k, absent in enumerate(found):
        first, last = math.floor(positions[k]) - beside, math.ceil(positions[k + 1]) + beside
        assert absent == lost[max(0, first) : max(0, last)].any()


def test_missing_samples_make_their_bins_missing() -> None:
    made, lost = window(), np.zeros(LENGTH, np.bool_)
    lost[MARGIN + 1000 : MARGIN + 2000] = True
    hop = made.add(segment(0, turning(10.0), missing=lost), 70.0, useless=False)
    assert hop is not None
    # A thousand samples, and half a margin on either side; a bin has 21 samples.
    assert hop.missing.sum() == pytest.approx((1000 + MARGIN) / (RATE / 10.0 / BINS), abs=2)


def test_the_power_of_a_hop_leaves_missing_bins_out() -> None:
    envelopes = np.array([[1.0, 2.0, 30.0], [3.0, 4.0, 50.0]], np.float32)
    assert Hop(envelopes, np.array([False, False, True]), 1.0).powers.tolist() == [1.5, 3.5]
    assert Hop(envelopes, np.ones(3, np.bool_), 1.0).powers.tolist() == [0.0, 0.0]


def test_a_shaft_at_rest_has_no_bins_and_huge_levels_are_limited() -> None:
    hop = window().add(segment(0, turning(0.0)), 70.0, useless=False)
    assert hop is not None
    assert (hop.envelopes.shape, len(hop.missing), hop.turns) == ((1, 0), 0, 0.0)
    hop = window().add(segment(0, turning(20.0), amplitude=1e20), 70.0, useless=False)
    assert hop is not None
    assert hop.envelopes.max() == np.float32(LARGEST)
    assert LARGEST == 1e30


@pytest.mark.parametrize(
    ("rate", "low", "periods", "samples"), [(51200, 1000.0, 10.0, 512), (51200, 999.0, 10.0, 513), (1000, 100.0, 3.0, 30)]
)
def test_the_margin_is_a_number_of_periods(rate: int, low: float, periods: float, samples: int) -> None:
    assert margin_samples(rate, low, periods) == samples

"""The average over the angle of a wheelset, on waves whose repeating part is known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from synthetic_bearing import RATE, TURN

from dcrb_ros.diagnosis.segments import Segment, Segmenter
from dcrb_ros.diagnosis.vehicle.turn_average import TurnAverage

HOP, MARGIN = RATE // 2, RATE // 100


def removed(turns: npt.NDArray[np.float64], wave: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return a wave without its average, hop by hop, without the samples before the start."""
    average = TurnAverage(HOP, MARGIN, 8)
    parts = [average.removed(segment) for segment in segments(turns, wave)]
    return np.concatenate([part.acceleration[MARGIN:-MARGIN, 1] for part in parts])[2 * MARGIN :]


def segments(turns: npt.NDArray[np.float64], wave: npt.NDArray[np.float64]) -> list[Segment]:
    """Return the segments of a wave."""
    angle = np.mod(TURN * turns, TURN).astype(np.float32)
    return list(Segmenter(HOP, MARGIN, 0).add(0, np.column_stack([np.zeros_like(wave), wave]), angle))


def rms(values: npt.NDArray[np.float64]) -> float:
    return float(np.sqrt(np.square(values).mean()))


TIME = np.arange(3 * RATE) / RATE


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("order", [1.0, 87.0, 250.0])
def test_whole_orders_are_removed_while_the_speed_rises(order: float, direction: float) -> None:
    turns = direction * (15.0 * TIME + 0.5 * TIME**2)
    assert rms(removed(turns, np.cos(TURN * order * turns))) < 0.02 * 0.5**0.5


def test_the_average_goes_on_where_samples_per_turn_pass_a_power_of_two() -> None:
    """There are 2048 samples in a turn at 25 Hz; the mean speed of the hops alternates between 24.9 and 25.1 Hz."""
    turns = 25.0 * TIME - 0.2 / TURN * np.cos(TURN * TIME)
    noise = np.random.default_rng(1).normal(size=len(TIME))
    assert np.square(removed(turns, noise)[-HOP:]).mean() == pytest.approx(1.0 - 1.0 / 75.0, abs=0.03)  # six hops of 12.5 turns
    assert rms(removed(turns, np.cos(TURN * 87.0 * turns))) < 0.02 * 0.5**0.5


@pytest.mark.parametrize("order", [7.31, 87.44])
def test_other_orders_are_kept(order: float) -> None:
    turns = 18.3 * TIME
    assert rms(removed(turns, np.cos(TURN * order * turns))) == pytest.approx(0.5**0.5, rel=0.1)


def test_noise_loses_its_share_of_the_turns() -> None:
    noise = np.random.default_rng(1).normal(size=len(TIME))
    kept = removed(20.0 * TIME, noise)[-HOP:]
    assert np.square(kept).mean() == pytest.approx(1.0 - 1.0 / 50.0, abs=0.03)  # five hops of ten turns


@pytest.mark.parametrize("turns", [0.5 * TIME, np.full_like(TIME, np.nan), 8.0 * np.sin(4.0 * TURN * TIME)])
def test_nothing_is_removed_without_turns_to_average(turns: npt.NDArray[np.float64]) -> None:
    average = TurnAverage(HOP, MARGIN, 8)
    assert all(average.removed(segment) is segment for segment in segments(turns, np.cos(TURN * 900.0 * TIME)))


def test_a_wheelset_that_turns_back_begins_anew() -> None:
    turns = np.where(TIME < 1.5, 20.0 * TIME, 20.0 * (3.0 - TIME))
    wave = np.cos(TURN * 87.0 * turns)
    assert rms(removed(turns, wave)[-HOP:]) < 0.02

"""The angle of the shaft from pulses of a tacho and from speeds: exact where they are, and refused where they mean nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros.exchange.pulse_train import LEVELS, counted_pulses, joined_turns, pulse_train, turns_at_speed, wrapped
from dcrb_ros.exchange.pulse_train import sampled_pulses as written_pulses
from dcrb_ros.schema.refusal import Refusal

RATE = 10_000.0


def sampled_pulses(turns: np.ndarray, per_turn: int) -> np.ndarray:
    """Pulses of a sixth of their distance whose edges rise within some samples, as those of a tacho behind an anti-alias filter."""
    phase = np.mod(turns * per_turn + 0.5, 1.0) - 0.5
    return np.clip(20.0 * phase + 0.5, 0.0, 1.0) * (phase < 1.0 / 6.0)


@given(
    st.integers(1, 8),
    st.floats(5.0, 30.0),
    st.floats(-0.3, 0.3),
    st.floats(-50.0, 50.0).filter(lambda scale: abs(scale) > 0.01),
    st.floats(-5.0, 5.0),
)
@settings(max_examples=40, deadline=None)
def test_pulses_give_the_turns_of_the_shaft(per_turn: int, speed: float, ramp: float, scale: float, offset: float) -> None:
    time = np.arange(20_000) / RATE
    turns = speed * (time + 0.5 * ramp * time**2)
    pulses = offset + abs(scale) * sampled_pulses(turns, per_turn)
    index = np.arange(len(turns))
    train = pulse_train(pulses, index, per_turn, None, "tacho")
    found = train.at(index)
    inside = (index > train.edges[0]) & (index < train.edges[-1])
    # Between edges the speed changes by ramp: a quarter of a pulse's turns squared, over eight, in relation to the speed.
    error = found[inside] - turns[inside]
    assert train.irregular == 0
    assert np.ptp(error) < 2e-3 / per_turn + abs(ramp) / speed / per_turn**2


def test_an_edge_lies_between_samples() -> None:
    index = np.arange(3000)
    turns = index / 250.3  # 39.95 Hz at 10 kHz
    found = pulse_train(sampled_pulses(turns, 1), index, 1, None, "tacho").edges
    assert np.diff(found) == pytest.approx(250.3, abs=0.02)


def test_noise_below_the_hysteresis_adds_no_edge() -> None:
    index = np.arange(20_000)
    clean = sampled_pulses(index / 400.0, 1)
    noisy = clean + np.random.default_rng(5).uniform(-0.15, 0.15, len(clean))
    assert len(pulse_train(noisy, index, 1, (0.25, 0.75), "tacho").edges) == len(pulse_train(clean, index, 1, None, "tacho").edges)


def test_missing_teeth_and_double_pulses_do_not_lose_the_count() -> None:
    """A wheel of 60 teeth without two of them, as on engines, and a pulse that bounced once."""
    index = np.arange(30_000)
    turns = index / 3000.0
    pulses = sampled_pulses(turns, 60)
    pulses[np.mod(np.floor(turns * 60.0 + 0.5), 60) >= 58.0] = 0.0
    train = pulse_train(pulses, index, 60, None, "tacho")
    assert train.irregular == 9
    assert np.ptp(train.at(index) - turns) < 1e-3
    bounced = sampled_pulses(turns, 6)
    bounced[1220:1225] = 1.0
    train = pulse_train(bounced, index, 6, None, "tacho")
    assert train.irregular == 1
    assert np.ptp(train.at(index) - turns) < 1e-3


def test_a_gap_between_samples_is_bridged_by_whole_pulses() -> None:
    index = np.concatenate([np.arange(5000), np.arange(5730, 12_000)])
    turns = index / 200.0
    train = pulse_train(sampled_pulses(turns, 1), index, 1, None, "tacho")
    assert np.ptp(train.at(index) - turns) < 1e-2
    assert train.irregular == 0


def test_gaps_between_short_files_are_no_missing_pulses() -> None:
    """Ten files of 1 s with five pulses each: every fifth interval between pulses is across a gap."""
    index = np.concatenate([np.arange(first, first + 1000) for first in range(0, 43_000, 4300)])
    turns = 5.0 * index / 1000.0
    train = pulse_train(sampled_pulses(turns, 1), index, 1, None, "tacho")
    assert train.irregular == 0
    assert np.ptp(train.at(index) - turns) < 1e-2
    with pytest.raises(Refusal, match="no two pulses without missing samples between them"):
        pulse_train(sampled_pulses(turns / 5.0, 1), index, 1, None, "tacho")


@pytest.mark.parametrize(
    ("pulses", "sentence"),
    [
        (np.zeros(1000), "has 0 rising edges through 0 and 0, but a speed needs 3"),
        (np.repeat([0.0, 1.0], 500), "has 1 rising edges"),
        ((np.random.default_rng(1).random(5000) < 0.02).astype(float), "intervals between pulses differ from their neighbours"),
    ],
)
def test_a_channel_without_regular_pulses_is_refused(pulses: np.ndarray, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        pulse_train(pulses, np.arange(len(pulses)), 1, None, "tacho")


def test_speeds_are_integrated_over_time_at_any_rate() -> None:
    time = np.arange(20_000) / RATE
    rpm = 600.0 + 300.0 * time
    exact = 10.0 * time + 2.5 * time**2
    index = np.arange(len(time))
    assert turns_at_speed(rpm, index, RATE, "rpm") == pytest.approx(exact, abs=1e-6)
    assert turns_at_speed(rpm[::16], index, RATE, "rpm")[:-16] == pytest.approx(exact[:-16], abs=1e-4)
    assert turns_at_speed(np.array([600.0]), index, RATE, "rpm") == pytest.approx(10.0 * time, abs=1e-6)
    rpm[3000:5000] = np.nan
    assert turns_at_speed(rpm, index, RATE, "rpm") == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("rpm", [np.full(10, np.nan), np.array([600.0, np.inf]), np.ones(101)])
def test_speeds_without_meaning_are_refused(rpm: np.ndarray) -> None:
    with pytest.raises(Refusal, match="give speeds in rpm, NaN where unknown, at most one per sample"):
        turns_at_speed(rpm, np.arange(100), RATE, "rpm")


def test_an_angle_stays_below_a_full_turn() -> None:
    angle = wrapped(np.array([0.0, 1.0 - 1e-12, 5.25, -0.25, np.nan]))
    assert ((angle[:4] >= 0.0) & (angle[:4] < np.float32(2.0 * np.pi))).all()
    assert np.isnan(angle[4])


@pytest.mark.parametrize("gap", [0, 1, 700])
def test_the_shaft_turns_on_between_files(gap: int) -> None:
    index = np.arange(1000)
    indices = [index, index + 1000 + gap, index + 2000 + 2 * gap]
    parts = [turns_at_speed(np.full(1000, 600.0), one, 1000.0, "rpm") for one in indices]
    assert joined_turns(parts, indices) == pytest.approx(np.concatenate(indices) / 100.0)
    assert joined_turns(parts[:1], indices[:1]) == pytest.approx(index / 100.0)
    assert joined_turns([np.zeros(1), np.zeros(1)], [np.array([0]), np.array([5])]).tolist() == [0.0, 0.0]


@given(st.lists(st.floats(4.0, 90.0), min_size=1, max_size=40), st.floats(1.0, 50.0), st.integers(0, 10**8))
@settings(max_examples=60, deadline=None)
def test_the_edges_of_a_sampled_tacho_are_found_again(intervals: list[float], first: float, begin: int) -> None:
    edges = begin + first + np.concatenate([[0.0], np.cumsum(intervals)])
    index = np.arange(begin, int(edges[-1]) + 100)
    signal = written_pulses(edges, index)
    assert signal.min() == 0.0
    assert signal.max() <= 1.0
    found = counted_pulses(signal.astype(np.float64), index, 7, LEVELS)
    assert len(found.edges) == len(edges)
    assert np.abs(found.edges - edges).max() < 1e-6
    assert np.array_equal(np.rint(7.0 * found.turns), np.arange(len(edges)))


def test_missing_samples_hide_pulses_which_are_counted() -> None:
    edges = 20.0 * np.arange(1, 50) + 0.3
    index = np.concatenate([np.arange(0, 305), np.arange(511, 1000)])
    found = counted_pulses(written_pulses(edges, index).astype(np.float64), index, 1, LEVELS)
    assert found.edges == pytest.approx(edges[(edges < 304.0) | (edges > 512.0)])
    assert found.turns[-1] == 48.0


def test_a_tacho_that_stands_still_counts_no_pulse() -> None:
    index = np.arange(1000)
    stopped = np.array([10.0, 20.0, 30.0, 900.0, 910.0])
    found = counted_pulses(written_pulses(stopped, index).astype(np.float64), index, 1, LEVELS)
    assert found.edges == pytest.approx(stopped)
    assert found.turns.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert written_pulses(np.zeros(0), index).tolist() == [0.0] * 1000
    assert len(counted_pulses(np.zeros(1000), index, 1, LEVELS).edges) == 0
    lone = counted_pulses(written_pulses(np.array([100.25]), index).astype(np.float64), index, 1, LEVELS)
    assert lone.edges == pytest.approx([100.25])

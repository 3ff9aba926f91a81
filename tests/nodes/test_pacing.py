"""Deadlines of blocks, on a clock made of a number."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.nodes.pacing import MAX_CATCH_UP, Pacer

BLOCK = 0.02


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def send(pacer: Pacer, clock: Clock, number: int, work: float) -> float:
    """Work on block ``number`` for a time [s], wait as told and return when it goes out [s]."""
    clock.now += work
    clock.now += pacer.until(number * BLOCK, (number + 1) * BLOCK)
    return clock.now


@given(st.floats(0.05, 20.0), st.integers(2, 50))
def test_blocks_go_out_at_the_scale_asked_for(scale: float, count: int) -> None:
    clock = Clock()
    pacer = Pacer(scale, clock)
    times = [send(pacer, clock, k, 0.1 * BLOCK / scale) for k in range(count + 2)]
    assert times[-1] - times[1] == pytest.approx(count * BLOCK / scale)
    assert pacer.late == 0


def test_scale_zero_never_waits() -> None:
    clock = Clock()
    pacer = Pacer(0.0, clock)
    assert [send(pacer, clock, k, 0.0) for k in range(5)] == [100.0] * 5


def test_a_short_stall_is_caught_up() -> None:
    clock = Clock()
    pacer = Pacer(1.0, clock)
    for k in range(3):
        send(pacer, clock, k, 0.0)
    expected = clock.now + 40 * BLOCK
    send(pacer, clock, 3, 0.3)
    assert pacer.late == 1
    for k in range(4, 43):
        send(pacer, clock, k, 0.0)
    assert clock.now == pytest.approx(expected)
    assert pacer.lag == 0.0


def test_a_long_stall_moves_the_deadlines() -> None:
    clock = Clock()
    pacer = Pacer(1.0, clock)
    for k in range(3):
        send(pacer, clock, k, 0.0)
    stalled = send(pacer, clock, 3, MAX_CATCH_UP + 10.0)
    assert send(pacer, clock, 4, 0.0) == pytest.approx(stalled + BLOCK)  # no rush afterwards


def test_a_new_scale_counts_from_now() -> None:
    clock = Clock()
    pacer = Pacer(1.0, clock)
    for k in range(3):
        send(pacer, clock, k, 0.0)
    before = clock.now
    pacer.scale = 0.5
    assert send(pacer, clock, 3, 0.0) == pytest.approx(before + 2.0 * BLOCK)

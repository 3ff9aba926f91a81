"""Deadlines of bundles, on a simulated wall clock."""

from __future__ import annotations

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.nodes.pacing import MAX_CATCH_UP, Pacer

BLOCK = 0.02
"""Simulated time of a block [s]."""
SLOW, REAL, FAST = 0.25, 1.0, 4.0
"""Time scales [-]: a block takes 80 ms, 20 ms and 5 ms of wall time."""


class Clock:
    """Wall time that passes when it is told to."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class Run:
    """Sends blocks of 20 ms at their deadlines."""

    def __init__(self, scale: float) -> None:
        self.clock = Clock()
        self.pacer = Pacer(scale, self.clock)
        self.sent = 0

    def send(self, work: float = 0.0) -> float:
        """Work on the next block for a wall time [s], wait as told and return the wall time at which it is sent [s]."""
        self.clock.now += work
        self.clock.now += self.pacer.until(self.sent * BLOCK, (self.sent + 1) * BLOCK)
        self.sent += 1
        return self.clock.now


@given(st.floats(0.05, 20.0), st.integers(2, 50))
def test_blocks_are_sent_at_the_requested_scale(scale: float, count: int) -> None:
    run = Run(scale)
    times = [run.send(work=0.1 * BLOCK / scale) for _ in range(count + 2)]
    assert times[-1] - times[1] == pytest.approx(count * BLOCK / scale)
    assert (run.pacer.late, run.pacer.lag) == (0, 0.0)


def test_the_first_block_is_sent_at_once_and_the_second_a_block_after_it_is_ready() -> None:
    run = Run(REAL)
    assert run.send(work=5.0) == 105.0
    assert run.send(work=0.5) == pytest.approx(105.5 + BLOCK)  # preparations while the first is sent are not caught up


def test_scale_zero_never_waits_and_is_never_late() -> None:
    run = Run(0.0)
    assert [run.send() for _ in range(5)] == [100.0] * 5
    assert run.send(work=3.0) == 103.0
    assert (run.pacer.late, run.pacer.lag) == (0, 0.0)


@pytest.mark.parametrize("scale", [SLOW, REAL, FAST])
def test_a_short_stall_is_caught_up(scale: float) -> None:
    run, duration = Run(scale), BLOCK / scale
    times = [run.send() for _ in range(3)]
    stalled = run.send(work=0.9)
    behind = 0.9 - duration
    assert stalled == pytest.approx(times[-1] + 0.9)
    assert run.pacer.lag == pytest.approx(behind)
    while run.pacer.lag > 0.0:
        run.send()
    assert run.sent - 4 == pytest.approx(behind / duration, abs=1.0)
    assert run.clock.now == pytest.approx(times[-1] + (run.sent - 3) * duration)


@pytest.mark.parametrize("scale", [SLOW, REAL, FAST])
@pytest.mark.parametrize(("stall", "late"), [(0.5, 0), (0.99, 0), (1.01, 1), (2.5, 1)])
def test_a_block_is_late_if_its_lag_exceeds_its_own_duration_in_wall_time(scale: float, stall: float, late: int) -> None:
    """The lag ``stall`` is given in durations of a block in wall time."""
    run, duration = Run(scale), BLOCK / scale
    for _ in range(3):
        run.send()
    run.send(work=(1.0 + stall) * duration)
    assert run.pacer.lag == pytest.approx(stall * duration)
    assert run.pacer.late == late


def test_the_longest_lag_that_is_caught_up_is_a_second_of_wall_time_at_any_scale() -> None:
    for scale in (SLOW, REAL, FAST):
        for stall, caught_up in ((0.98 * MAX_CATCH_UP, True), (1.02 * MAX_CATCH_UP, False)):
            run, duration = Run(scale), BLOCK / scale
            for _ in range(3):
                last = run.send()
            stalled = run.send(work=stall + duration)
            following = run.send()
            assert following == pytest.approx(max(stalled, last + 2.0 * duration) if caught_up else stalled + duration)


@pytest.mark.parametrize(("lag", "late", "next_wait"), [(0.25, 0, 0.0), (0.5, 1, 0.0), (1.0, 1, 0.0), (1.25, 1, 0.25)])
def test_limits_belong_to_the_punctual_side(lag: float, late: int, next_wait: float) -> None:
    """With blocks of 0.25 s, so that all sums are exact: a lag of 0.25 s is not late, and one of 1 s is caught up."""
    clock = Clock()
    pacer = Pacer(REAL, clock)
    assert (pacer.lag, pacer.late) == (0.0, 0)
    assert [pacer.until(0.25 * k, 0.25 * (k + 1)) for k in range(2)] == [0.0, 0.25]
    clock.now += 0.25 + 0.25 + lag
    assert pacer.until(0.5, 0.75) == 0.0
    assert (pacer.lag, pacer.late) == (lag, late)
    assert pacer.until(0.75, 1.0) == next_wait


def test_no_rush_follows_a_long_stall() -> None:
    run = Run(REAL)
    for _ in range(3):
        run.send()
    stalled = run.send(work=MAX_CATCH_UP + 10.0)
    assert run.pacer.lag == pytest.approx(MAX_CATCH_UP + 10.0 - BLOCK)
    assert [run.send() for _ in range(3)] == pytest.approx([stalled + k * BLOCK for k in (1, 2, 3)])


def test_a_new_scale_counts_from_the_next_block() -> None:
    run = Run(REAL)
    for _ in range(3):
        run.send()
    before = run.send(work=0.5)
    run.pacer.scale = 0.5
    assert (run.pacer.scale, run.pacer.lag) == (0.5, 0.0)
    assert [run.send() for _ in range(2)] == pytest.approx([before + 2.0 * BLOCK, before + 4.0 * BLOCK])


def test_a_restart_does_not_catch_up_and_start_over_sends_the_next_block_at_once() -> None:
    run = Run(REAL)
    for _ in range(3):
        run.send()
    before = run.send(work=0.5)
    run.pacer.restart()
    assert run.pacer.lag == 0.0
    before = run.send()
    run.pacer.start_over()
    assert run.send(work=0.1) == pytest.approx(before + 0.1)
    assert run.send() == pytest.approx(before + 0.1 + BLOCK)


def test_a_scale_near_zero_waits_as_long_as_a_lock_can() -> None:
    run = Run(1e-300)
    run.send()
    assert run.pacer.until(BLOCK, 2.0 * BLOCK) == threading.TIMEOUT_MAX

"""Simulated time: in integer nanoseconds, and durations given by the user."""

from __future__ import annotations

from dcrb_ros.schema.numbers import duration_within

MAX_DURATION = 1e6
"""Longest simulated duration that is accepted [s]."""


def nanoseconds(count: int, rate: int) -> int:
    """Return the simulated time [ns] of tick ``count`` of a clock with ``rate`` ticks per second [Hz], rounded down."""
    return count * 1_000_000_000 // rate


def next_tick(step: int, rate: int, step_rate: int) -> int:
    """Return the first step after ``step``, of ``step_rate`` per second, at which a clock of ``rate`` [Hz] ticks."""
    tick = step * rate // step_rate + 1
    return -(-tick * step_rate // rate)


def checked_duration(duration: float) -> float:
    """Return a duration [s] given with --duration.

    Raises:
        Refusal: it is not a number above 0 and up to `MAX_DURATION`.
    """
    return duration_within("--duration", duration, MAX_DURATION, "give the simulated time to run in seconds")

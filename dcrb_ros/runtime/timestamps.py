"""Simulated time in integer nanoseconds."""

from __future__ import annotations


def nanoseconds(count: int, rate: int) -> int:
    """Return the simulated time [ns] of tick ``count`` of a clock of ``rate`` ticks a second [Hz], rounded down."""
    return count * 1_000_000_000 // rate

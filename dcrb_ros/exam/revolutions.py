"""Shaft revolutions over simulated time, for a speed that is linear between given times."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.vehicle_speed import SPEED
from dcrb_ros.simulation.scenario import RAMPS, ScheduledChange

Knot = tuple[float, float]
"""Time [s] and speed [rad/s]."""


def revolutions(knots: Sequence[Knot], begin: float, end: float) -> float:
    """Return the revolutions from ``begin`` to ``end`` [s], counted in either direction [-].

    n = integral of |omega| dt / (2 pi). The speed is constant before the first and after the last knot, and 0 without knots.
    """
    if not knots or end <= begin:
        return 0.0
    times = [begin, *(time for time, _ in knots if begin < time < end), end]
    speeds = [_speed(knots, time) for time in times]
    angles = (_angle(t1 - t0, v0, v1) for t0, t1, v0, v1 in zip(times, times[1:], speeds, speeds[1:], strict=False))
    return math.fsum(angles) / (2.0 * math.pi)


def _speed(knots: Sequence[Knot], time: float) -> float:
    """Return the speed at a time [rad/s]."""
    before = knots[0]
    for after in knots:
        if after[0] >= time:
            span = after[0] - before[0]
            return after[1] if span <= 0.0 else before[1] + (after[1] - before[1]) * (time - before[0]) / span
        before = after
    return before[1]


def _angle(span: float, first: float, last: float) -> float:
    """Return the integral of the absolute value of a linear speed over ``span`` seconds [rad]."""
    if first * last >= 0.0:
        return 0.5 * span * (abs(first) + abs(last))
    return 0.5 * span * (first * first + last * last) / (abs(first) + abs(last))


def speed_knots(configuration: Configuration, changes: Iterable[ScheduledChange]) -> tuple[Knot, ...]:
    """Return the speed of a run as knots: every target is approached at the ramp that holds at the time."""
    return tuple(_knots(configuration, changes))


def _knots(configuration: Configuration, changes: Iterable[ScheduledChange]) -> Iterator[Knot]:
    time, speed = 0.0, configuration.operating.speed
    target, ramp = speed, configuration.operating.speed_ramp
    yield time, speed
    for change in changes:
        if not {SPEED, RAMPS[SPEED]} & set(change.changes):
            continue
        now = change.step / configuration.step_rate
        yield from _approach(time, speed, target, ramp, now)
        reach = ramp * (now - time)
        speed = target if abs(target - speed) <= reach else speed + math.copysign(reach, target - speed)
        time, target, ramp = now, float(change.changes.get(SPEED, target)), float(change.changes.get(RAMPS[SPEED], ramp))
        yield time, speed
    yield from _approach(time, speed, target, ramp, math.inf)


def _approach(time: float, speed: float, target: float, ramp: float, until: float) -> Iterator[Knot]:
    """Yield the knot at which the target is reached, if that is before ``until``."""
    reached = time + abs(target - speed) / ramp
    if time < reached < until:
        yield reached, target

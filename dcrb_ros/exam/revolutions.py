"""Shaft revolutions over simulated time, for a speed that is linear between given times."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.vehicle_speed import SPEED
from dcrb_ros.simulation.scenario import RAMPS, ScheduledChange

Knot = tuple[float, float]
"""Time [s] and speed [rad/s]."""


def revolutions(knots: Sequence[Knot] | Floats, begin: float, end: float) -> float:
    """Return the revolutions from ``begin`` to ``end`` [s], counted in either direction [-].

    n = integral of |omega| dt / (2 pi). The speed is constant before the first and after the last knot, and 0 without knots.
    """
    if not len(knots) or end <= begin:
        return 0.0
    known, speed = np.asarray(knots, np.float64).T
    times = np.concatenate([[begin], known[np.searchsorted(known, begin, "right") : np.searchsorted(known, end)], [end]])
    speeds = np.interp(times, known, speed)
    first, last = speeds[:-1], speeds[1:]
    both = np.abs(first) + np.abs(last)
    # Where a speed changes its sign, the integral is that of two triangles.
    mean = np.where(first * last >= 0.0, both, (first**2 + last**2) / np.maximum(both, np.finfo(np.float64).tiny))
    return math.fsum(0.5 * np.diff(times) * mean) / (2.0 * math.pi)


def speed_knots(configuration: Configuration, changes: Iterable[ScheduledChange]) -> Iterator[Knot]:
    """Yield the speed of a run as knots: every target is approached at the ramp that holds at the time."""
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

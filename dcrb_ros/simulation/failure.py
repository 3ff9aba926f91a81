"""The failure of a model that left its domain."""

from __future__ import annotations

import math

from dcrb_ros.core.layout.state import State
from dcrb_ros.schema.arrays import Floats


class ModelFailure(RuntimeError):
    """The model left its domain: a result is not a number, the outer ring left its seat, or the bearing burnt off. The run is over."""


def failure_at(time_ns: int, reason: str) -> ModelFailure:
    """Return the failure at a simulated time [ns]."""
    return ModelFailure(f"the model failed at {time_ns / 1e9:.6f} s: {reason}")


def check_domain(time_ns: int, acceleration: Floats, state: State, limit: float) -> None:
    """Check the acceleration [m/s^2] and the state that a model reached at a simulated time [ns].

    Raises
    ------
    ModelFailure
        An acceleration is not finite, or the outer ring is ``limit`` [m] or more off its seat.
    """
    off_seat = max(map(abs, state.outer_position.tolist()))
    if not (math.isfinite(float(acceleration.sum())) and off_seat < limit):
        raise failure_at(
            time_ns,
            f"the outer ring is {off_seat:.3g} m off its seat; a shorter simulation.step or a smaller load keeps it in its domain",
        )

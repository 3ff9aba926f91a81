"""The time step and the seed of a run.

A stage draws from a stream of its own, which follows from the seed and its name: `dcrb_ros.measurement.random_streams`. Rules about the
step and other parameters are in `step_limits`.
"""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity

SHORTEST_STEP, LONGEST_STEP = 1e-7, 2e-5
"""Range of the time step [s]."""


class SimulationParameters(Group):
    """Time step and seed of a run."""

    step: float = quantity(
        1.0 / 102400.0,
        "s",
        "Time step; a sampling interval must be a whole number of steps",
        SHORTEST_STEP,
        LONGEST_STEP,
        symbol="h",
        remedy="the contacts oscillate at up to 18 kHz and need 20 us or less",
    )
    seed: int = quantity(1, "-", "Seed of every random number", 0, 2**31 - 1)

"""The level of the healthy bearing at the sensor, to which a background refers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.measured_rate import preview_at, preview_rates, rates
from dcrb_ros.simulation.run import LONGEST, simulate

STARTING = 0.2
"""Time that a run takes to settle [s]."""
FASTEST_SAMPLING = 60000
"""Highest sampling rate at which the level is measured [Hz]: its pass band just exceeds the 20 kHz of the definition."""
SLOWEST_SAMPLING = 48000
"""Lowest sampling rate at which the level is measured [Hz]: its pass band ends at 19.2 kHz."""
USUAL_SAMPLING = 51200
"""Sampling rate at which the level is measured if no rate between these two divides the rate of the steps [Hz]."""
REPLACED = ("faults", "background", "sensor", "publishing", "recording", "tacho")
"""Groups that a machine has no part in."""


def healthy_level(
    configuration: Configuration | str | Path = "healthy",
    duration: float = 1.0,
    *,
    settings: Mapping[str, Any] | Sequence[str] | str = (),
) -> float:
    """Simulate a machine without faults and background and return its level for ``structure.healthy_level``.

    The level belongs to a machine: bearing, operating point and path. Use the same level in the configurations of its faults, and with
    another speed of the shaft give that of the level as ``structure.healthy_speed``.

    Parameters
    ----------
    configuration
        A `Configuration`, the name of a shipped one or a YAML file; its faults, background and sensor errors are left out.
    duration
        Simulated time after 0.2 s to settle, up to 3599 s [s].
    settings
        Parameters to change, as for `simulate`.

    Returns
    -------
    float
        Rms of the acceleration up to 20 kHz, the mean of the powers in X and Y [m/s^2].

    Raises
    ------
    Refusal
        An unknown configuration or parameter, a value out of range, or a duration that is not above 0 and at most 3599 s.

    Examples
    --------
    >>> import dcrb_ros
    >>> machine = {"structure.housing": "axle_box", "structure.seed": 3}
    >>> level = dcrb_ros.healthy_level("healthy", 0.3, settings=machine)
    >>> settings = {**machine, "structure.healthy_level": level, "structure.background": 3.0, "structure.floor": 0.1}
    >>> dcrb_ros.simulate("outer_ring_defect", 0.1, settings=settings)
    <SimulationResult: 0.1 s at 51.2 kHz (5120 samples), shaft at 20.02 Hz, outer_1: 2 mm wide>
    """
    duration = duration_within("duration =", duration, LONGEST - 1.0, "one second is enough")
    given = load_configuration(configuration, settings)
    kept = given.model_dump()
    rate, step = _sampling(given)
    machine = {
        **{name: group for name, group in kept.items() if name not in REPLACED},
        "simulation": kept["simulation"] | {"step": step},
        "structure": kept["structure"] | dict.fromkeys(("healthy_level", "healthy_speed", "background", "background_lines", "floor"), 0.0),
        "sensor": {"preset": "ideal", "sampling_rate": rate},
        "publishing": {"preview_rate": preview_at(rate)},
    }
    run = simulate(Configuration.model_validate(machine), STARTING + duration)
    settled = run.acceleration[round(STARTING * rate) :].astype(float)
    return float(np.sqrt(np.mean(settled**2)))


def _sampling(given: Configuration) -> tuple[int, float]:
    """Return a sampling rate [Hz] and a step [s]: the highest rate up to 60 kHz of whole steps, or a usual one with a shorter step."""
    steps = given.step_rate
    rate = next((steps // factor for factor in range(2, steps) if steps % factor == 0 and steps // factor <= FASTEST_SAMPLING), 0)
    if rate >= SLOWEST_SAMPLING and preview_rates(rate):
        return rate, given.simulation.step
    return USUAL_SAMPLING, rates(USUAL_SAMPLING, given.simulation.step)["simulation.step"]

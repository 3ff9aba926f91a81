"""Comparison of the production solver with the paper's own formulation, over a time too short for chaos to separate them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.reference.solver import History, ReferenceSolver
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.comparison import Comparison
from dcrb_ros.validation.runs import BENCH

STEP = 1e-6
"""Step of both solvers [s]; the classical scheme of Eqs. 39 and 40 needs it to resolve the friction."""
LARGEST_NORMAL_DEVIATION = 1e-3
"""Accepted relative RMS deviation of the normal forces [-]."""
LARGEST_DRIFT = 1e-12
"""Accepted violation of the constraints [m or rad]."""


class Agreement(NamedTuple):
    """The deviation between the two solvers."""

    acceleration: float
    """Relative RMS deviation of the outer ring's acceleration [-]."""
    normal: float
    """Relative RMS deviation of the normal forces of all rollers at the inner raceway [-]."""
    history: History
    """The run of the reference solver."""


class Window(NamedTuple):
    """A short run on which the solvers are compared."""

    setting: str
    """The fault as KEY=VALUE; empty for a healthy bearing."""
    duration: float
    """[s]"""
    largest_deviation: float
    """Accepted relative RMS deviation of the acceleration [-]."""


WINDOWS = {
    "healthy": Window("", 1e-3, 1e-3),
    "outer ring defect": Window("faults.outer_1.width=0.002", 1.5e-3, 1e-2),
    # The reference solver diverges where a freed roller strikes a bar, at any clearance that was tried (20 um after 2.4 ms, 10 um at once).
    "one broken bar, before a roller touches another": Window("faults.broken_bars=row1/bar15", 3e-3, 2e-2),
}


def production(configuration: Configuration, duration: float) -> tuple[Floats, Floats]:
    """Return the production solver's mean acceleration in each step and its inner normal forces at the middle of each step.

    Shapes (steps, 2) [m/s^2] and (steps, rows, rollers) [N].
    """
    payload = build_payload(configuration)._replace(step=STEP)
    state = initial_state(configuration, payload)
    work, steps = workspace(payload), round(duration / STEP)
    acceleration, normal, angle = np.empty((steps, 2)), np.empty((steps, *state.spin_angle.shape)), np.empty(1)
    for n in range(steps):
        advance(payload, state, work, acceleration[n : n + 1], angle)
        normal[n] = state.inner_force
    return acceleration, normal


def deviation(found: Floats, expected: Floats) -> float:
    """Return the relative RMS deviation of two arrays of the same shape [-]."""
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def agreement(configuration: Configuration, duration: float) -> Agreement:
    """Run both solvers for ``duration`` [s] and return the deviation between them."""
    history = ReferenceSolver(configuration).advance(duration, STEP)
    acceleration, normal = production(configuration, duration)
    return Agreement(
        deviation(acceleration, _step_means(history.outer_acceleration)), deviation(normal, _step_means(history.inner_normal)), history
    )


def compare_solvers(name: str) -> Agreement:
    """Return the deviation between the solvers in one of `WINDOWS`."""
    window = WINDOWS[name]
    return agreement(load_configuration(BENCH["revolute"], [window.setting] if window.setting else []), window.duration)


def _step_means(instants: Floats) -> Floats:
    """Return the mean over each step of values at its ends, shape (steps, ...) from (steps + 1, ...)."""
    return 0.5 * (instants[1:] + instants[:-1])


def formulation_comparisons(agreements: Mapping[str, Agreement]) -> Iterator[Comparison]:
    """Yield the comparison of the solvers in each of `WINDOWS`."""
    for name, (_, duration, most) in WINDOWS.items():
        found = agreements[name]
        drift = float(found.history.drift.max())
        yield Comparison(
            f"Motion by the paper's formulation (111 coordinates, multipliers), {name}, {duration * 1e3:g} ms",
            "revolute",
            "Eqs. 31-40",
            f"acceleration {found.acceleration:.1e}, normal forces {found.normal:.1e}, constraint drift {drift:.0e} m",
            f"relative RMS {most:.0e}, {LARGEST_NORMAL_DEVIATION:.0e}; drift {LARGEST_DRIFT:.0e} m",
            found.acceleration <= most and found.normal <= LARGEST_NORMAL_DEVIATION and drift <= LARGEST_DRIFT,
        )

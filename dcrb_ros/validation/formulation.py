"""Comparison of the production solver with the paper's own formulation, over a time too short for chaos to separate them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state, pocket_azimuths
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.reference.bodies import ANGLE, pocket_directions
from dcrb_ros.validation.reference.solver import History, ReferenceSolver
from dcrb_ros.validation.report_row import ReportRow
from dcrb_ros.validation.runs import BENCH

STEP = 1e-6
"""Step of both solvers [s]; the classical scheme of Eqs. 39 and 40 needs it to resolve the friction."""
LARGEST_NORMAL_DEVIATION = 1e-3
"""Accepted relative RMS deviation of the normal forces [-]."""
LARGEST_DRIFT = 1e-12
"""Accepted violation of the constraints [m or rad]."""


LARGEST_REBOUND_DEVIATION = 2e-3
"""Accepted deviation of the velocity with which a roller rebounds from a bar, relative to that before [-]."""
THROWN = 7
"""The thrown roller in row 1, counted from 0."""


class Agreement(NamedTuple):
    """The deviation between the two solvers."""

    acceleration: float
    """Relative RMS deviation of the outer ring's acceleration [-]."""
    normal: float
    """Relative RMS deviation of the normal forces of all rollers at the inner raceway [-]."""
    rebound: float
    """Deviation of the thrown roller's velocity at the end, relative to the speed at which it was thrown [-]; 0 if none is."""
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
    thrown: float = 0.0
    """Speed at which roller 8 of row 1 is thrown against the bar behind it [m/s]; 0 for none."""


WINDOWS = {
    "healthy": Window("", 1e-3, 1e-3),
    "outer ring defect": Window("faults.outer_1.width=0.002", 1.5e-3, 1e-2),
    "one broken bar, a freed roller strikes the other": Window("faults.broken_bars=row1/bar8", 7e-4, 5e-3, thrown=0.2),
}


def production(configuration: Configuration, duration: float, thrown: float = 0.0) -> tuple[Floats, Floats, Floats]:
    """Return the production solver's mean acceleration in each step, its inner normal forces at the middle of each step, and the
    velocity of the thrown roller at the end.

    Shapes (steps, 2) [m/s^2], (steps, rows, rollers) [N] and (2,) [m/s].
    """
    payload = build_payload(configuration)._replace(step=STEP)
    state = initial_state(configuration, payload)
    state.roller_velocity[0, THROWN, :ANGLE] += throw(configuration, thrown)
    work, steps = workspace(payload), round(duration / STEP)
    acceleration, normal, angle = np.empty((steps, 2)), np.empty((steps, *state.spin_angle.shape)), np.empty(1)
    for n in range(steps):
        advance(payload, state, work, acceleration[n : n + 1], angle)
        normal[n] = state.inner_force
    return acceleration, normal, state.roller_velocity[0, THROWN, :ANGLE].copy()


def throw(configuration: Configuration, speed: float) -> Floats:
    """Return the change of velocity [m/s] of the thrown roller, against the direction in which the pockets follow each other."""
    return -speed * pocket_directions(pocket_azimuths(configuration.bearing)[0, THROWN])[1]


def deviation(values: Floats, expected: Floats) -> float:
    """Return the relative RMS deviation of two arrays of the same shape [-]."""
    return float(np.linalg.norm(values - expected) / np.linalg.norm(expected))


def agreement(configuration: Configuration, duration: float, thrown: float = 0.0) -> Agreement:
    """Run both solvers for ``duration`` [s], with a roller thrown at a speed [m/s], and return the deviation between them."""
    reference = ReferenceSolver(configuration)
    body = reference.bodies.roller_bodies[0, THROWN]
    reference.state.velocity[body, :ANGLE] += throw(configuration, thrown)
    history = reference.advance(duration, STEP)
    acceleration, normal, velocity = production(configuration, duration, thrown)
    apart = float(np.linalg.norm(velocity - reference.state.velocity[body, :ANGLE]))
    return Agreement(
        deviation(acceleration, _step_means(history.outer_acceleration)),
        deviation(normal, _step_means(history.inner_normal)),
        apart / thrown if thrown else 0.0,
        history,
    )


def compare_solvers(name: str) -> Agreement:
    """Return the deviation between the solvers in one of `WINDOWS`."""
    window = WINDOWS[name]
    return agreement(load_configuration(BENCH["revolute"], [window.setting] if window.setting else []), window.duration, window.thrown)


def _step_means(instants: Floats) -> Floats:
    """Return the mean over each step of values at its ends, shape (steps, ...) from (steps + 1, ...)."""
    return 0.5 * (instants[1:] + instants[:-1])


def formulation_rows(agreements: Mapping[str, Agreement]) -> Iterator[ReportRow]:
    """Yield the comparison of the solvers in each of `WINDOWS`."""
    for name, (_, duration, most, thrown) in WINDOWS.items():
        deviations = agreements[name]
        drift = float(deviations.history.drift.max())
        yield ReportRow(
            f"Motion by the paper's formulation (111 coordinates, multipliers), {name}, {duration * 1e3:g} ms",
            "revolute",
            "Eqs. 31-40",
            f"acceleration {deviations.acceleration:.1e}, normal forces {deviations.normal:.1e}, constraint drift {drift:.0e} m"
            + (f", rebound {deviations.rebound:.1e}" if thrown else ""),
            f"relative RMS {most:.0e}, {LARGEST_NORMAL_DEVIATION:.0e}; drift {LARGEST_DRIFT:.0e} m"
            + (f"; rebound {LARGEST_REBOUND_DEVIATION:.0e} of the speed" if thrown else ""),
            deviations.acceleration <= most
            and deviations.normal <= LARGEST_NORMAL_DEVIATION
            and drift <= LARGEST_DRIFT
            and deviations.rebound <= LARGEST_REBOUND_DEVIATION,
        )

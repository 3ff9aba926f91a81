"""The production solver held against the paper's own formulation, over a window before chaos sets in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.reference.solver import History, Reference
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

STEP = 1e-6
"""Step of both solvers [s]: the classical scheme of Eqs. 39 and 40 must resolve the friction."""


class Agreement(NamedTuple):
    """How far the two solvers are apart."""

    acceleration: float
    """Outer ring's acceleration, relative RMS [-]."""
    normal: float
    """Normal forces of all rollers at the inner raceway, relative RMS [-]."""
    history: History
    """The reference's run."""


def production(configuration: Configuration, duration: float) -> tuple[Floats, Floats]:
    """Return the production solver's mean acceleration over each step and its inner normal forces at each step's middle."""
    payload = build_payload(configuration)._replace(step=STEP)
    state = initial_state(configuration, payload)
    work, steps = workspace(payload), round(duration / STEP)
    acceleration, normal, angle = np.empty((steps, 2)), np.empty((steps, *state.spin_angle.shape)), np.empty(1)
    for n in range(steps):
        advance(payload, state, work, acceleration[n : n + 1], angle)
        normal[n] = state.inner_force
    return acceleration, normal


def deviation(found: Floats, expected: Floats) -> float:
    """Return the relative RMS deviation [-]; any shape."""
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def agreement(configuration: Configuration, duration: float) -> Agreement:
    """Run both solvers for ``duration`` [s] and compare them."""
    history = Reference(configuration).advance(duration, STEP)
    acceleration, normal = production(configuration, duration)
    return Agreement(
        deviation(acceleration, _over_steps(history.outer_acceleration)), deviation(normal, _over_steps(history.inner_normal)), history
    )


def _over_steps(instants: Floats) -> Floats:
    """Return the means over the steps between instants."""
    return 0.5 * (instants[1:] + instants[:-1])

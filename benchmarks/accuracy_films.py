"""Accuracy: how the step affects both rings as they swing on loaded rollers, with and without oil films.

The error is the largest of eight instants: at a single one an error that oscillates may pass through zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration

STEPS = tuple(1e-5 / 2**k for k in range(6))
EXACT_STEP = 1e-5 / 256
DURATION, INSTANTS = 4e-4, 8
"""Time compared, and instants in it [s]."""
IMPACT = 0.01, -0.02
"""Velocity by which the inner ring is struck in X and Y [m/s]."""
OIL = ("lubrication.law=film", "contact.loss_time=1e-5", "friction.convection=0.7")


@dataclass(frozen=True)
class Case:
    """A bearing with pinned rollers."""

    name: str
    settings: tuple[str, ...]


CASES = (
    Case("dry", ()),
    Case("dry, loss and convection as with films", OIL[1:]),
    Case("film", OIL),
    Case("film without resistance to rolling", (*OIL, "lubrication.rolling_resistance=false")),
    Case("film without squeeze film", (*OIL, "lubrication.squeeze=false")),
)


def swing(settings: tuple[str, ...], step: float) -> Floats:
    """Return the centres of both rings at all instants, shape (instants, 4) [m]."""
    configuration = load_configuration("dry", ("cage.joint=revolute", *settings))
    payload = build_payload(configuration)
    state, payload = initial_state(configuration, payload), payload._replace(step=step)
    state.inner_velocity[:2] += IMPACT
    work, count, places = workspace(payload), round(DURATION / step) // INSTANTS, []
    for _ in range(INSTANTS):
        advance(payload, state, work, np.empty((count, 2)), np.empty(count))
        places.append([*state.inner_position[:2], *state.outer_position[:2]])
    return np.array(places)


def main() -> None:
    """Print a table."""
    print("| case | " + " | ".join(f"{1e6 * step:.3g} us [pm]" for step in STEPS) + " |\n|---|" + "---|" * len(STEPS))
    for case in CASES:
        exact = swing(case.settings, EXACT_STEP)
        errors = [1e12 * float(np.abs(swing(case.settings, step) - exact).max()) for step in STEPS]
        print(f"| {case.name} | " + " | ".join(f"{error:.0f}" for error in errors) + " |", flush=True)


if __name__ == "__main__":
    main()

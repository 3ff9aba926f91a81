"""Accuracy: drift of the energy without friction and damping."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from accuracy_table import STEP, Entry, percent, print_table, step_name

from dcrb_ros.bearing.energy import energy_of_bars, energy_of_lands, kinetic_energy, potential_of_weight
from dcrb_ros.bearing.equilibrium import penetrations, stored_energy
from dcrb_ros.bearing.observation import place_pinned_rollers
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration

FRICTIONLESS = {"kinetic_coefficient": 0.0, "static_coefficient": 1e-9, "bristle_damping": 0.0, "bristle_stiffness": 1.0}
UNDAMPED: dict[str, Any] = {"contact": {"loss_time": 0.0}, "housing": {"damping": 0.0}, "friction": FRICTIONLESS}
BLOW = 0.02
"""Speed given to the inner ring [m/s]."""
WINDOW = 128
"""Steps over which the energy is averaged [-]; the energy of the leapfrog scheme oscillates with the phase of a mode within a step."""
MOST_DRIFT = 0.01


class Swing(NamedTuple):
    """A case without friction and damping, at rest until the inner ring gets an initial speed."""

    name: str
    cage: dict[str, Any]
    gravity: float
    """[m/s^2]."""
    windows: int
    """Length of the run in windows of the default step [-]."""
    blows: tuple[float, ...]
    """Speeds given to the inner ring [m/s]."""
    parts: tuple[int, ...]
    """Numbers of steps in a default step [-]."""


SWINGS = (
    Swing("revolute", {"joint": "revolute"}, 9.81, 8, (BLOW,), (1,)),
    Swing("pocket, no weight", {"joint": "pocket"}, 0.0, 8, (0.5 * BLOW, BLOW, 5.0 * BLOW), (1,)),
    Swing("pocket", {"joint": "pocket"}, 9.81, 8, (0.5 * BLOW, BLOW, 2.5 * BLOW, 5.0 * BLOW), (1, 4)),
)


def mechanical_energy(payload: Payload, state: State) -> float:
    """Return the kinetic and potential energy of a bearing with smooth raceways at the end of a step [J]."""
    place_pinned_rollers(payload, state)
    _, _, *depths = penetrations(payload, state.outer_position, state.inner_position, state.roller_position)
    energy = kinetic_energy(payload, state) + potential_of_weight(payload, state) - float(state.load @ state.inner_position)
    energy += 0.5 * payload.housing_stiffness * float(state.outer_position @ state.outer_position)
    energy += energy_of_bars(payload, state) + energy_of_lands(payload, state)
    sites = (payload.inner, payload.outer)
    return energy + sum(float(stored_energy(payload, depth, site).sum()) for depth, site in zip(depths, sites, strict=True))


def drift(case: Swing, blow: float, part: int) -> tuple[float, float]:
    """Return the largest change of the mean energy in a window, relative to the excitation and to the energy of the blow [-].

    Without friction the cages fall onto their lands and into the rollers; the work of their weight is a part of the excitation.
    """
    cage = {"restitution": 1.0, **case.cage}
    configuration = Configuration.model_validate({**UNDAMPED, "operating": {"speed": 0.0, "gravity": case.gravity}, "cage": cage})
    payload = build_payload(configuration)._replace(step=STEP / part)
    state, work = initial_state(configuration, payload), workspace(payload)
    state.inner_velocity[1] = -blow

    def height() -> float:
        """Return the potential energy of the cages and the rollers in pockets, which can fall [J]."""
        rings = payload.outer_mass * state.outer_position[1] + payload.inner_mass * state.inner_position[1]
        return potential_of_weight(payload, state) - payload.gravity * float(rings) if payload.any_free else 0.0

    energies, heights = [], [height()]
    for _ in range(WINDOW * case.windows * part):
        advance(payload, state, work, np.empty((1, 2)), np.empty(1))
        energies.append(mechanical_energy(payload, state))
        heights.append(height())
    means = np.array(energies).reshape(case.windows, -1).mean(axis=1)
    changed, struck = float(np.abs(means - means[0]).max()), 0.5 * payload.inner_mass * blow**2
    return changed / (struck + heights[0] - min(heights)), changed / struck


def drifts() -> Iterator[Entry]:
    """Yield the drift of the energy for every case."""
    for case, blow, part in ((swing, blow, part) for swing in SWINGS for blow in swing.blows for part in swing.parts):
        found = drift(case, blow, part)
        cells = (case.name, f"{blow:g}", step_name(part), f"{1e3 * WINDOW * case.windows * STEP:.2f}", *map(percent, found))
        yield Entry(cells, found[0] < MOST_DRIFT if part == 1 else None)


def energy_table() -> bool:
    """Print the drift of the energy."""
    heads = ("case", "initial speed [m/s]", "step", "time [ms]", "drift", "relative to the blow")
    tolerance = (
        f"Without friction and damping, after a blow to the inner ring, means over {1e3 * WINDOW * STEP:g} ms. Tolerance at the default "
        f"step h: {100.0 * MOST_DRIFT:g} % of the energy of the blow and of the falling bodies."
    )
    return print_table("Energy", tolerance, heads, drifts())

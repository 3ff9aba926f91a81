"""Comparisons of the time integration: energy without friction and loss, and the order of convergence."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.bearing.energy import energy_of_bars, energy_of_lands, kinetic_energy, potential_of_weight
from dcrb_ros.bearing.equilibrium import penetrations, radial_directions, stored_energy
from dcrb_ros.bearing.observation import place_pinned_rollers
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import State, copy_of
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.simulation import SimulationParameters
from dcrb_ros.validation.report_row import ReportRow

CHAPTER = "Time integration"
STEP = SimulationParameters().step
"""The default step [s]."""

FRICTIONLESS = {"kinetic_coefficient": 0.0, "static_coefficient": 1e-9, "bristle_damping": 0.0, "bristle_stiffness": 1.0}
LOSSLESS: dict[str, Any] = {"contact": {"loss_time": 0.0}, "housing": {"damping": 0.0}, "friction": FRICTIONLESS}
WINDOW, WINDOWS = 128, 8
"""Steps over which the energy is averaged, and windows of a run [-]. The energy of the leapfrog scheme oscillates within a step."""


class Blow(NamedTuple):
    """A bearing at rest without friction and loss, whose inner ring is struck."""

    joint: str
    gravity: float
    """[m/s^2]"""
    speeds: tuple[float, ...]
    """Speeds given to the inner ring, one in each run [m/s]."""


BLOWS = (Blow("revolute", 9.81, (0.02,)), Blow("pocket", 0.0, (0.02,)), Blow("pocket", 9.81, (0.01, 0.1)))
MOST_DRIFT = 0.006
"""Accepted change of the energy [-]."""


def mechanical_energy(payload: Payload, state: State) -> float:
    """Return the kinetic and potential energy of a bearing with smooth raceways at the end of a step [J]."""
    place_pinned_rollers(payload, state)
    _, _, *depths = penetrations(payload, state.outer_position, state.inner_position, state.roller_position)
    energy = kinetic_energy(payload, state) + potential_of_weight(payload, state) - float(state.load @ state.inner_position)
    energy += 0.5 * payload.housing_stiffness * float(state.outer_position @ state.outer_position)
    energy += energy_of_bars(payload, state) + energy_of_lands(payload, state)
    sites = (payload.inner, payload.outer)
    return energy + sum(float(stored_energy(payload, depth, site).sum()) for depth, site in zip(depths, sites, strict=True))


def potential_of_falling_bodies(payload: Payload, state: State) -> float:
    """Return the potential energy of cages and rollers in pockets, which can fall [J]."""
    rings = payload.outer_mass * state.outer_position[1] + payload.inner_mass * state.inner_position[1]
    return potential_of_weight(payload, state) - payload.gravity * float(rings) if payload.any_free else 0.0


def energy_drift(blow: Blow, speed: float) -> float:
    """Return the largest change of the mean energy in a window [-].

    It is relative to the energy of the blow and of the falling bodies: without friction, cages and rollers fall onto each other.
    """
    operating = {"speed": 0.0, "gravity": blow.gravity}
    configuration = Configuration.model_validate({**LOSSLESS, "operating": operating, "cage": {"joint": blow.joint, "restitution": 1.0}})
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)
    state.inner_velocity[1] = -speed
    energies, heights = [], [potential_of_falling_bodies(payload, state)]
    for _ in range(WINDOW * WINDOWS):
        advance(payload, state, work, np.empty((1, 2)), np.empty(1))
        energies.append(mechanical_energy(payload, state))
        heights.append(potential_of_falling_bodies(payload, state))
    means = np.array(energies).reshape(WINDOWS, -1).mean(axis=1)
    return float(np.abs(means - means[0]).max()) / (0.5 * payload.inner_mass * speed**2 + heights[0] - min(heights))


def energy_rows() -> Iterator[ReportRow]:
    """Yield the drift of the energy without friction and loss."""
    for blow in BLOWS:
        drifts = [energy_drift(blow, speed) for speed in blow.speeds]
        speeds = ", ".join(f"{speed:g}" for speed in blow.speeds)
        yield ReportRow(
            f"Energy without friction and loss, {1e3 * WINDOW * WINDOWS * STEP:.0f} ms after a blow of {speeds} m/s"
            + ("" if blow.gravity else ", without weight"),
            blow.joint,
            "-",
            ", ".join(f"{100.0 * drift:.2f}" for drift in drifts) + " % off",
            f"{100.0 * MOST_DRIFT:g} %",
            max(drifts) <= MOST_DRIFT,
            CHAPTER,
        )


ORDER_STEPS = (8e-6, 4e-6, 2e-6, 1e-6)
COMMON = 8e-6
"""Interval at which runs with different steps are compared [s]."""
EXACT_STEP, SETTLING_STEP = 6.25e-8, 5e-7
PASSAGE = 4.096e-3
"""Time compared, in which the roller moves by 12 degrees around the middle of the load zone [s]."""
SETTLING = 2e-3
START_AZIMUTH = -0.25
"""Azimuth at which the roller starts to settle, already loaded [rad]."""
SETTLING_BRISTLE_DAMPING = 0.1
"""Bristle damping while settling [s/m]: it removes the 35 kHz oscillation of the sticking roller, which a step of 8 us cannot resolve."""
FIXED = 1e12
"""Mass of a ring that does not move [kg]."""
ORDERS = 1.95, 2.05
"""Accepted orders of convergence; the scheme is of second order [-]."""


def lone_roller() -> tuple[Payload, State]:
    """Return a bearing in which one roller passes the load zone; the five others rest in the gap without contact.

    The inner ring rotates at a fixed position; the outer ring moves on the housing. There are no bars, so the roller is driven by
    friction only.
    """
    configuration = Configuration.model_validate(
        {"bearing": {"rows": 1, "rollers_per_row": 6}, "cage": {"joint": "pocket"}, "operating": {"load": 30e3, "gravity": 0.0}}
    )
    payload = build_payload(configuration)._replace(step=SETTLING_STEP, inner_mass=FIXED, broken=np.ones((1, 6), np.bool_))
    state = initial_state(configuration, payload)
    state.load[:] = state.target[1:] = 0.0
    state.cage_velocity[:] = 0.0
    state.roller_velocity[0, 1:] = 0.0
    state.roller_position[0, 1:] = 0.5 * (state.outer_position + state.inner_position)
    state.roller_position[0, 1:] += payload.pitch_radius * radial_directions(payload)[0, 1:]
    cosine, sine = math.cos(START_AZIMUTH), math.sin(START_AZIMUTH)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    state.roller_position[0, 0] = state.outer_position + turn @ (state.roller_position[0, 0] - state.outer_position)
    state.roller_velocity[0, 0, :2] = turn @ state.roller_velocity[0, 0, :2]
    settling = payload._replace(traction_law=payload.traction_law._replace(bristle_damping=SETTLING_BRISTLE_DAMPING))
    steps = round(SETTLING / payload.step)
    advance(settling, state, workspace(payload), np.empty((steps, 2)), np.empty(steps))
    return payload, state


def with_step(payload: Payload, state: State, step: float) -> tuple[Payload, State]:
    """Return the payload and a copy of the state with another step [s]."""
    copy = copy_of(state)
    for change in (copy.change, copy.earlier_change, copy.roller_change):
        change *= step / payload.step
    return payload._replace(step=step), copy


def passage(payload: Payload, state: State) -> Floats:
    """Return the centres of outer ring and first roller at the common times, shape (times, 2, 2) [m]."""
    work, steps = workspace(payload), round(COMMON / payload.step)
    centres = []
    for _ in range(round(PASSAGE / COMMON)):
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))
        centres.append([state.outer_position.copy(), state.roller_position[0, 0].copy()])
    if max(state.inner_force[0, 1:].max(), state.outer_force[0, 1:].max()) > 0.0 or state.inner_force[0, 0] == 0.0:
        raise RuntimeError("the first roller, and no other, must be in contact: check the parameters of the case")
    return np.array(centres)


def convergence_orders() -> list[float]:
    """Return the orders of convergence [-] of outer ring and roller, without loss in the contacts and with it."""
    payload, state = lone_roller()
    orders: list[float] = []
    for loss_time in (0.0, payload.loss_time):
        case = payload._replace(loss_time=loss_time)
        exact = passage(*with_step(case, state, EXACT_STEP))
        errors = [np.linalg.norm(passage(*with_step(case, state, step)) - exact, axis=(0, 2)) for step in ORDER_STEPS]
        orders += np.polyfit(np.log(ORDER_STEPS), np.log(errors), 1)[0].tolist()
    return orders


def order_row() -> ReportRow:
    """Compare the order of convergence with two."""
    orders = convergence_orders()
    return ReportRow(
        "Order of convergence, one roller passing the load zone, steps of 8 to 1 us: ring and roller without loss, with loss",
        "pocket",
        "-",
        ", ".join(f"{order:.3f}" for order in orders),
        f"{ORDERS[0]:g} to {ORDERS[1]:g}",
        all(ORDERS[0] <= order <= ORDERS[1] for order in orders),
        CHAPTER,
    )

"""Accuracy: order of convergence of one roller in the load zone."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from accuracy_table import Entry, Floats, print_table

from dcrb_ros.bearing.equilibrium import radial_directions
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import State, copy_of
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration

ORDER_STEPS = (8e-6, 4e-6, 2e-6, 1e-6)
COMMON = 8e-6
"""Interval at which runs with different steps are compared [s]."""
EXACT_STEP = 6.25e-8
SETTLING_STEP = 5e-7
PASSAGE = 4.096e-3
"""Time compared, in which the roller moves by 12 degrees around the middle of the load zone [s]."""
SETTLING = 2e-3
START_AZIMUTH = -0.25
"""Azimuth at which the roller starts to settle, already loaded [rad]."""
SETTLING_BRISTLE_DAMPING = 0.1
"""Bristle damping while settling [s/m]: it removes the 35 kHz oscillation of the sticking roller, which a step of 8 us cannot resolve."""
FIXED = 1e12
"""Mass of a ring that does not move [kg]."""


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
    """Return the centres of outer ring and first roller at the common times, shape (times, 4) [m]."""
    work, steps = workspace(payload), round(COMMON / payload.step)
    places = []
    for _ in range(round(PASSAGE / COMMON)):
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))
        places.append([*state.outer_position, *state.roller_position[0, 0]])
    if max(state.inner_force[0, 1:].max(), state.outer_force[0, 1:].max()) > 0.0 or state.inner_force[0, 0] == 0.0:
        raise RuntimeError("the first roller, and no other, must be in contact: check the parameters of the case")
    return np.array(places)


def orders() -> Iterator[Entry]:
    """Yield errors and order of convergence for the lone roller, without and with contact damping."""
    payload, state = lone_roller()
    for name, loss_time in (("friction", 0.0), ("friction and damping", payload.loss_time)):
        case = payload._replace(loss_time=loss_time)
        exact = passage(*with_step(case, state, EXACT_STEP))
        errors = [passage(*with_step(case, state, step)) - exact for step in ORDER_STEPS]
        for body, columns in (("outer ring", slice(0, 2)), ("roller", slice(2, 4))):
            sizes = [math.sqrt(float((error[:, columns] ** 2).sum(axis=1).mean())) for error in errors]
            order = float(np.polyfit(np.log(ORDER_STEPS), np.log(sizes), 1)[0])
            yield Entry((name, body, *(f"{1e12 * size:.4g}" for size in sizes), f"{order:.3f}"), 1.8 <= order <= 2.2)


def order_table() -> bool:
    """Print the order of convergence."""
    heads = ("case", "body", *(f"{1e6 * step:g} us [pm]" for step in ORDER_STEPS), "order")
    return print_table("Order of convergence, one roller in the load zone", "Error of positions; order within 1.8 .. 2.2.", heads, orders())

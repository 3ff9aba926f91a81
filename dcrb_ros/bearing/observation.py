"""Published states of the bodies from the state of the kernels."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.bearing.film_observation import observe_lubrication
from dcrb_ros.core import observation as of
from dcrb_ros.core.layout.state import SHAFT_SPEED, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.states import States, ThermalState


def wrapped(angle: Floats) -> Floats:
    """Return angles [rad] wrapped to (-pi, pi]."""
    return math.pi - np.mod(math.pi - angle, 2.0 * math.pi)


def place_pinned_rollers(payload: Payload, state: State) -> None:
    """Write position and velocity of the pinned rollers, which move with their cages."""
    if not payload.all_free:
        of.place_pinned(state.rollers, payload.free, payload.pocket_tangent, state.position, state.velocity, payload.pitch_radius)


def observe(payload: Payload, state: State, time_ns: int, before: States | None = None, thermal: ThermalState | None = None) -> States:
    """Return the states of all bodies at ``time_ns``, with temperatures; ``before`` are the states since which powers are averaged."""
    oil = before.lubrication if before is not None else None
    since = (0.0, np.zeros(())) if before is None or oil is None else (1e-9 * before.time_ns, oil.friction_loss)
    place_pinned_rollers(payload, state)
    rows, count = len(payload.free), payload.free.size
    observed = np.zeros((of.OBSERVED, count + rows + 1))
    surface = float(state.shaft[SHAFT_SPEED]) * payload.inner_raceway_radius
    radius, share = payload.roller_radius, payload.spin_share
    force = of.observe_rollers(state.rollers, payload.free, state.position, state.velocity, surface, radius, share, observed)
    cages, ring, tangent = observed[:, count:-1], observed[:, -1], payload.pocket_tangent[:, 0]
    cages[of.AZIMUTH] = np.arctan2(tangent[:, 1], tangent[:, 0]) + state.cage_position[:, 2]
    cages[of.SPEED], cages[of.BAR_FORCE] = state.cage_velocity[:, 2], state.land[0].force[:rows]
    ring[of.AZIMUTH], ring[of.SPEED] = state.shaft
    ring[of.INNER_FORCE] = observed[of.INNER_FORCE, :count].sum()
    return States(
        time_ns=time_ns,
        azimuth=wrapped(observed[of.AZIMUTH]),
        speed=observed[of.SPEED],
        inner_force=observed[of.INNER_FORCE],
        outer_force=observed[of.OUTER_FORCE],
        slip=observed[of.SLIP],
        friction=observed[of.FRICTION],
        torque=observed[of.TORQUE],
        relative_speed=observed[of.RELATIVE_SPEED],
        bar_force=observed[of.BAR_FORCE],
        cage_offset=state.cage_position[:, :2] - state.outer_position,
        inner_ring_force=force,
        lubrication=observe_lubrication(payload, state, 1e-9 * time_ns, since),
        thermal=thermal,
    )

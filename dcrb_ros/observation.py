"""From the kernels' state to what is published of it: the bodies' states and the energy account."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.block import Floats, States
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import State
from dcrb_ros.energy import account
from dcrb_ros.equilibrium import radial_directions


def wrapped(angle: Floats) -> Floats:
    """Return angles [rad] wrapped to (-pi, pi]."""
    return math.pi - np.mod(math.pi - angle, 2.0 * math.pi)


def place_pinned_rollers(payload: Payload, state: State) -> None:
    """Write position and velocity of the pinned rollers, which their cages carry."""
    if payload.all_free:
        return
    cosine, sine = np.cos(state.cage_position[:, 2, None]), np.sin(state.cage_position[:, 2, None])
    at_zero, pinned = radial_directions(payload), ~payload.free
    arm = payload.pitch_radius * np.stack(
        [cosine * at_zero[..., 0] - sine * at_zero[..., 1], sine * at_zero[..., 0] + cosine * at_zero[..., 1]], axis=-1
    )
    turning = state.cage_velocity[:, None, 2, None] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
    state.roller_position[pinned] = (state.cage_position[:, None, :2] + arm)[pinned]
    state.roller_velocity[pinned, :2] = (state.cage_velocity[:, None, :2] + turning)[pinned]


def inner_normals(state: State) -> Floats:
    """Return the directions from the inner ring to each roller, shape (rows, rollers, 2) [-]."""
    offset = state.roller_position - state.inner_position
    return np.asarray(offset / np.hypot(offset[..., :1], offset[..., 1:]))


def inner_slip(payload: Payload, state: State, normal: Floats) -> Floats:
    """Return the slip at the inner raceway of every roller, touching or not, shape (rows, rollers) [m/s]."""
    velocity = state.roller_velocity[..., :2] - state.inner_velocity
    passing = velocity[..., 1] * normal[..., 0] - velocity[..., 0] * normal[..., 1]
    slip: Floats = passing - state.roller_velocity[..., 2] * payload.roller_radius - state.shaft[1] * payload.inner_raceway_radius
    return slip


def force_on_inner_ring(state: State, normal: Floats) -> tuple[float, float]:
    """Return the total force of the rollers on the inner ring in X and Y [N]."""
    nx, ny = normal[..., 0], normal[..., 1]
    push, hold = state.inner_force, state.inner_friction
    return float((-push * nx - hold * ny).sum()), float((hold * nx - push * ny).sum())


def observe(payload: Payload, state: State, time_ns: int, stored_at_start: float) -> States:
    """Return the states of all bodies at ``time_ns``; ``stored_at_start`` [J] is what the energy account began with."""
    place_pinned_rollers(payload, state)
    offset = state.roller_position - state.outer_position
    azimuth = np.arctan2(offset[..., 0], -offset[..., 1])
    pocket = np.arctan2(payload.pocket_tangent[:, 0, 1], payload.pocket_tangent[:, 0, 0]) + state.cage_position[:, 2]
    normal = inner_normals(state)
    cages, none = state.cage_velocity[:, 2], np.zeros(len(state.cage_position) + 1)
    spin = state.roller_velocity[..., 2]

    def bodies(rollers: Floats, others: Floats) -> Floats:
        return np.concatenate([rollers.ravel(), others])

    return States(
        time_ns=time_ns,
        azimuth=wrapped(bodies(azimuth, np.array([*pocket, state.shaft[0]]))),
        speed=bodies(spin, np.array([*cages, state.shaft[1]])),
        inner_force=bodies(state.inner_force, np.array([*none[:-1], state.inner_force.sum()])),
        outer_force=bodies(state.outer_force, none),
        slip=bodies(inner_slip(payload, state, normal), none),
        friction=bodies(state.inner_friction, none),
        torque=bodies(payload.roller_radius * (state.inner_friction - state.outer_friction), none),
        relative_speed=bodies(spin - cages[:, None], none),
        bar_force=bodies(state.bar_force, np.array([*state.land_force, 0.0])),
        cage_offset=state.cage_position[:, :2] - state.outer_position,
        inner_ring_force=force_on_inner_ring(state, normal),
        energy=account(payload, state, stored_at_start),
    )

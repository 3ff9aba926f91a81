"""From the kernels' state to what is published of it: the bodies' states and the ground truth."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.block import Floats, States
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import State


def wrapped(angle: Floats) -> Floats:
    """Return angles [rad] wrapped to (-pi, pi]."""
    return math.pi - np.mod(math.pi - angle, 2.0 * math.pi)


def roller_frames(payload: Payload, state: State) -> tuple[Floats, Floats]:
    """Return each pocket's tangent and each roller's normal from the inner ring, shape (rows, rollers, 2) [-]."""
    cosine, sine = np.cos(state.cage_position[:, 2, None]), np.sin(state.cage_position[:, 2, None])
    px, py = payload.pocket_tangent[..., 0], payload.pocket_tangent[..., 1]
    tangent = np.stack([cosine * px - sine * py, sine * px + cosine * py], axis=-1)
    radial = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
    offset = state.cage_position[:, None, :2] - state.inner_position + payload.pitch_radius * radial
    return tangent, offset / np.linalg.norm(offset, axis=-1, keepdims=True)


def inner_slip(payload: Payload, state: State) -> Floats:
    """Return the slip at the inner raceway of every roller, touching or not, shape (rows, rollers) [m/s]."""
    tangent, normal = roller_frames(payload, state)
    rim_speed = payload.pitch_radius * state.cage_velocity[:, None, 2, None]
    velocity = state.cage_velocity[:, None, :2] + rim_speed * tangent - state.inner_velocity
    passing = velocity[..., 1] * normal[..., 0] - velocity[..., 0] * normal[..., 1]
    slip: Floats = passing - state.spin * payload.roller_radius - state.shaft[1] * payload.inner_raceway_radius
    return slip


def force_on_inner_ring(payload: Payload, state: State) -> tuple[float, float]:
    """Return the total force of the rollers on the inner ring in X and Y [N]."""
    _, normal = roller_frames(payload, state)
    along = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
    force = (state.inner_friction[..., None] * along - state.inner_force[..., None] * normal).sum(axis=(0, 1))
    return float(force[0]), float(force[1])


def observe(payload: Payload, state: State, time_ns: int) -> States:
    """Return the states of all bodies at ``time_ns``."""
    pocket = np.arctan2(payload.pocket_tangent[..., 1], payload.pocket_tangent[..., 0])
    azimuth = pocket + state.cage_position[:, 2, None]
    none = np.zeros(len(state.cage_position) + 1)

    def bodies(rollers: Floats, others: Floats) -> Floats:
        return np.concatenate([rollers.ravel(), others])

    return States(
        time_ns=time_ns,
        azimuth=wrapped(bodies(azimuth, np.array([*azimuth[:, 0], state.shaft[0]]))),
        speed=bodies(state.spin, np.array([*state.cage_velocity[:, 2], state.shaft[1]])),
        inner_force=bodies(state.inner_force, np.array([*none[:-1], state.inner_force.sum()])),
        outer_force=bodies(state.outer_force, none),
        slip=bodies(inner_slip(payload, state), none),
        friction=bodies(state.inner_friction, none),
        inner_ring_force=force_on_inner_ring(payload, state),
    )

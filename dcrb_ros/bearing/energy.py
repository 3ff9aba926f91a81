"""The energy account: work done, energy dissipated and stored; its residual measures the error of the integration."""

from __future__ import annotations

import numpy as np

from dcrb_ros.bearing.equilibrium import energy_under, penetration_under
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.state import FRICTION, HOUSING, LOAD, LOSS, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.states import Account

LEAST_FORCE = 1e-9
"""Normal force used for an open contact [N]."""


def inner_product(a: Floats, b: Floats) -> float:
    """Return the sum of products of two vectors; that of the linear algebra library has other bits on other processors."""
    return float((a * b).sum())


def energy_of_force(payload: Payload, force: Floats, site: Site) -> Floats:
    """Return the energy [J] of contacts under normal forces [N]; any shape."""
    closed = np.maximum(force, LEAST_FORCE)
    return energy_under(payload, closed, penetration_under(payload, closed, site))


def energy_of_bars(payload: Payload, state: State) -> float:
    """Return the elastic energy of the contacts of free rollers with their bars at the present positions [J]."""
    if not payload.any_free:
        return 0.0
    cosine, sine = np.cos(state.cage_position[:, 2, None]), np.sin(state.cage_position[:, 2, None])
    px, py = payload.pocket_tangent[..., 0], payload.pocket_tangent[..., 1]
    arm = state.roller_position[..., :2] - state.cage_position[:, None, :2]
    along = arm[..., 0] * (cosine * px - sine * py) + arm[..., 1] * (sine * px + cosine * py)
    barred = payload.free & ~np.where(along > 0.0, payload.broken, np.roll(payload.broken, 1, axis=1))
    depth = np.where(barred, np.maximum(np.abs(along) - payload.pocket_clearance, 0.0), 0.0)
    return float((payload.bar_coefficient * depth ** (payload.bar_exponent + 1.0) / (payload.bar_exponent + 1.0)).sum())


def energy_of_lands(payload: Payload, state: State) -> float:
    """Return the elastic energy of the contacts of the cages with their lands at the present positions [J]."""
    offset = np.linalg.norm(state.cage_position[:, :2] - state.outer_position, axis=-1)
    depth = np.maximum(offset - payload.land_clearance, 0.0)
    return float((payload.land_coefficient * depth ** (payload.land_exponent + 1.0)).sum()) / (payload.land_exponent + 1.0)


def elastic_energy(payload: Payload, state: State) -> float:
    """Return the elastic energy of the housing and of all contacts [J]; of raceways and roller pairs at the forces of the last step."""
    energy = 0.5 * payload.housing_stiffness * inner_product(state.outer_position, state.outer_position)
    pair_force = state.of_rollers(state.rollers[0].pair.force)
    for force, site in ((state.inner_force, payload.inner), (state.outer_force, payload.outer), (pair_force, payload.pair)):
        energy += float(energy_of_force(payload, force, site).sum())
    return energy + energy_of_bars(payload, state) + energy_of_lands(payload, state)


def potential_of_weight(payload: Payload, state: State) -> float:
    """Return the potential energy of all weights [J]."""
    free = payload.free
    moment = payload.outer_ring_mass * state.outer_position[1] + payload.inner_ring_mass * state.inner_position[1]
    moment += inner_product(payload.train_mass, state.cage_position[:, 1]) + payload.roller_mass * float(
        state.roller_position[free, 1].sum()
    )
    cosine, sine = np.cos(state.cage_position[:, 2]), np.sin(state.cage_position[:, 2])
    # The centre of mass of the pinned rollers is a quarter turn behind the sum of their tangents.
    moment += float((-cosine * payload.train_moment[:, 0] + sine * payload.train_moment[:, 1]).sum())
    return payload.gravity * float(moment)


def kinetic_energy(payload: Payload, state: State) -> float:
    """Return the kinetic energy of all bodies except that of the driven rotation of the inner ring [J]."""
    rings = payload.outer_mass * inner_product(state.outer_velocity, state.outer_velocity)
    rings += payload.inner_mass * inner_product(state.inner_velocity, state.inner_velocity)
    linear, turning = state.cage_velocity[:, :2], state.cage_velocity[:, 2]
    cosine, sine = np.cos(state.cage_position[:, 2]), np.sin(state.cage_position[:, 2])
    mx, my = payload.train_moment[:, 0], payload.train_moment[:, 1]
    swept = (cosine * mx - sine * my) * linear[:, 0] + (sine * mx + cosine * my) * linear[:, 1]
    cages = (
        inner_product(payload.train_mass, (linear**2).sum(axis=1))
        + inner_product(payload.train_inertia, turning**2)
        + 2.0 * (turning * swept).sum()
    )
    rollers = payload.roller_inertia * (state.roller_velocity[..., 2] ** 2).sum()
    rollers += payload.roller_mass * (state.roller_velocity[payload.free, :2] ** 2).sum()
    return 0.5 * float(rings + cages + rollers)


def stored_energy(payload: Payload, state: State) -> float:
    """Return the sum of kinetic, elastic and potential energy [J]."""
    return kinetic_energy(payload, state) + elastic_energy(payload, state) + potential_of_weight(payload, state)


def account(payload: Payload, state: State, stored_at_start: float) -> Account:
    """Return the energy account since the start."""
    booked = state.account
    return Account(
        drive=float(state.of_rollers(state.rollers[0].drive_work).sum()),
        load=float(booked[LOAD]),
        friction=float(booked[FRICTION] + state.of_rollers(state.rollers[0].friction_loss).sum()),
        loss=float(booked[LOSS] + state.of_rollers(state.rollers[0].contact_loss).sum()),
        housing=float(booked[HOUSING]),
        notch=float(state.of_rollers(state.rollers[0].notch_loss).sum()),
        stored=stored_energy(payload, state) - stored_at_start,
    )

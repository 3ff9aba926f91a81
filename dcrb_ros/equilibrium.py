"""Static equilibrium of the bearing under its load, without friction: where every run starts."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.special import lambertw

from dcrb_ros.block import Floats
from dcrb_ros.core.payload import Payload

START_PENETRATION = 2e-5
"""Penetration of the lowest roller that the search starts from [m]."""


def johnson_forces(penetration: Floats, modulus: float, scale: float) -> Floats:
    """Return Johnson's normal forces [N], zero where the penetration [m] is not above zero.

    The library's Lambert W instead of the kernels' Newton steps; any shape.
    """
    closed = penetration > 0.0
    depth = np.where(closed, penetration, 1.0)
    forces = -modulus * depth / lambertw(-np.e * depth / scale, -1).real
    return np.where(closed, forces, 0.0)


def roller_forces(payload: Payload, centres: Floats) -> tuple[Floats, Floats]:
    """Return the forces on each roller from the inner and from the outer raceway, shape (rows, rollers, 2) [N].

    ``centres`` holds outer ring, inner ring and the cages, shape (2 + rows, 2) [m].
    """
    tangent = payload.pocket_tangent
    pins = payload.pitch_radius * np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
    rollers = centres[2:, None, :] + pins
    inner, outer = rollers - centres[1], rollers - centres[0]
    inner_distance, outer_distance = np.linalg.norm(inner, axis=-1), np.linalg.norm(outer, axis=-1)
    reach = payload.roller_radius
    inner_force = johnson_forces(payload.inner_raceway_radius + reach - inner_distance, payload.contact_modulus, payload.inner_scale)
    outer_force = johnson_forces(outer_distance + reach - payload.outer_raceway_radius, payload.contact_modulus, payload.outer_scale)
    return (
        (inner_force / inner_distance)[..., None] * inner,
        -(outer_force / outer_distance)[..., None] * outer,
    )


def unbalanced_forces(payload: Payload, load: Floats, centres: Floats) -> Floats:
    """Return the force left on outer ring, inner ring and cages, shape (2 + rows, 2) [N]; zero in equilibrium."""
    inner, outer = roller_forces(payload, centres)
    rows = len(centres) - 2
    masses = np.array([payload.outer_ring_mass, payload.inner_ring_mass, *[payload.train_mass] * rows])
    force = np.zeros_like(centres)
    force[:, 1] = -masses * payload.gravity
    force[0] += -payload.housing_stiffness * centres[0] - outer.sum(axis=(0, 1))
    force[1] += load - inner.sum(axis=(0, 1))
    force[2:] += (inner + outer).sum(axis=1)
    return force


def static_equilibrium(payload: Payload, load: Floats) -> Floats:
    """Return the centres of outer ring, inner ring and cages at rest under ``load`` [N], shape (2 + rows, 2) [m].

    The cages stand at angle zero and no defect is under a roller. The search starts with the rings pressed together
    along the load so that it cannot fall into the gap.
    """
    rows = payload.pocket_tangent.shape[0]
    weight = np.array([0.0, -payload.gravity * (payload.inner_ring_mass + rows * payload.train_mass)])
    total = load + weight
    size = float(np.linalg.norm(total))
    direction = total / size if size > 0.0 else np.array([0.0, -1.0])
    half_gap = 0.5 * (payload.outer_raceway_radius - payload.inner_raceway_radius) - payload.roller_radius
    centres = np.zeros((2 + rows, 2))
    centres[0] = total / payload.housing_stiffness
    centres[1] = centres[0] + (2.0 * half_gap + 2.0 * START_PENETRATION) * direction
    middle = 0.5 * (payload.inner_raceway_radius + payload.outer_raceway_radius) - payload.pitch_radius
    centres[2:] = centres[0] + (half_gap + START_PENETRATION + middle) * direction
    scale = max(size, 1.0)

    def residual(x: Floats) -> Floats:
        left: Floats = unbalanced_forces(payload, load, x.reshape(centres.shape) * 1e-6) / scale
        return left.ravel()

    found = least_squares(residual, centres.ravel() * 1e6, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=20000)
    settled: Floats = found.x.reshape(centres.shape) * 1e-6
    return settled

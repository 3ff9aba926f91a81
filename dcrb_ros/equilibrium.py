"""Static equilibrium of the bearing under its load, without friction: where every run starts."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.special import lambertw

from dcrb_ros.block import Floats
from dcrb_ros.core.payload import Payload

START_PENETRATION = 2e-5
"""Penetration of the lowest roller that the search starts from [m]."""

MICROMETRE = 1e-6


def johnson_forces(penetration: Floats, modulus: float, scale: float) -> Floats:
    """Return Johnson's normal forces [N], zero where the penetration [m] is not above zero.

    The library's Lambert W instead of the kernels' Newton steps; any shape.
    """
    closed = penetration > 0.0
    depth = np.where(closed, penetration, 1.0)
    forces = -modulus * depth / lambertw(-np.e * depth / scale, -1).real
    return np.where(closed, forces, 0.0)


def penetrations(payload: Payload, centres: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the vectors from inner and outer ring to each roller and the penetrations there [m].

    ``centres`` holds outer ring, inner ring and the cages, shape (2 + rows, 2) [m].
    """
    tangent = payload.pocket_tangent
    pins = payload.pitch_radius * np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
    rollers = centres[2:, None, :] + pins
    inner, outer = rollers - centres[1], rollers - centres[0]
    inner_depth = payload.inner_raceway_radius + payload.roller_radius - np.linalg.norm(inner, axis=-1)
    outer_depth = np.linalg.norm(outer, axis=-1) + payload.roller_radius - payload.outer_raceway_radius
    return inner, outer, inner_depth, outer_depth


def roller_forces(payload: Payload, centres: Floats) -> tuple[Floats, Floats]:
    """Return the forces on each roller from the inner and from the outer raceway, shape (rows, rollers, 2) [N]."""
    inner, outer, inner_depth, outer_depth = penetrations(payload, centres)
    inner_force = johnson_forces(inner_depth, payload.contact_modulus, payload.inner_scale)
    outer_force = johnson_forces(outer_depth, payload.contact_modulus, payload.outer_scale)
    return (
        inner * (inner_force / np.linalg.norm(inner, axis=-1))[..., None],
        -outer * (outer_force / np.linalg.norm(outer, axis=-1))[..., None],
    )


def potential_energy(payload: Payload, load: Floats, centres: Floats) -> float:
    """Return the energy of contacts, housing, weight and load [J]; a contact stores F delta/2 - F^2/(4 pi E* L)."""
    _, _, *depths = penetrations(payload, centres)
    rows = len(centres) - 2
    masses = np.array([payload.outer_ring_mass, payload.inner_ring_mass, *[payload.train_mass] * rows])
    energy = 0.5 * payload.housing_stiffness * centres[0] @ centres[0] - load @ centres[1] + payload.gravity * masses @ centres[:, 1]
    for depth, scale in zip(depths, (payload.inner_scale, payload.outer_scale), strict=True):
        force = johnson_forces(depth, payload.contact_modulus, scale)
        energy += np.sum(0.5 * force * depth - force**2 / (4.0 * payload.contact_modulus))
    return float(energy)


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

    def energy(x: Floats) -> tuple[float, Floats]:
        at = x.reshape(centres.shape) * MICROMETRE
        force = unbalanced_forces(payload, load, at)
        return potential_energy(payload, load, at) / (scale * MICROMETRE), -force.ravel() / scale

    def residual(x: Floats) -> Floats:
        return -energy(x)[1]

    # The energy leads over open contacts, where the forces alone give no direction; least squares then polish.
    lowest = minimize(energy, centres.ravel() / MICROMETRE, jac=True, method="BFGS", options={"gtol": 1e-6, "maxiter": 5000}).x
    found = least_squares(residual, lowest, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=20000).x
    settled: Floats = found.reshape(centres.shape) * MICROMETRE
    return settled

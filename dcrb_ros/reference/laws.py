"""The laws of contact and friction, each with its equation number in Fan et al. 2025; arrays of any one shape."""

from __future__ import annotations

import numpy as np
from scipy.special import lambertw

from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.contact import Friction

FLOOR_SPEED = 1e-3
"""Least impact speed that the loss of a bar contact is referred to [m/s]."""

SMALL_CLEARANCE, LARGE_CLEARANCE = 0.005, 0.34954
"""Clearances between which Pereira's first branch holds [mm]."""


def johnson(penetration: Floats, modulus: float, radius_difference: float) -> tuple[Floats, Floats]:
    """Return normal force [N] and stiffness [N/m], Eq. 4 solved for the force: F = -pi E* L delta / W_-1(-e delta / (4 dR)).

    ``modulus`` is E* L [N/m], ``radius_difference`` dR [m]; both are zero where the penetration [m] is not above zero.
    """
    closed = penetration > 0.0
    depth = penetration[closed]
    w = lambertw(-np.e * depth / (4.0 * radius_difference), -1).real
    force, stiffness = np.zeros_like(penetration), np.zeros_like(penetration)
    force[closed] = -np.pi * modulus * depth / w
    stiffness[closed] = -np.pi * modulus / (w + 1.0)
    return force, stiffness


def with_loss(force: Floats, stiffness: Floats, loss_time: float, rate: Floats) -> Floats:
    """Return a contact force with its loss k beta d(delta)/dt [N]; a contact never pulls. The paper has no loss."""
    lossy: Floats = np.maximum(force + stiffness * loss_time * rate, 0.0)
    return lossy


def stribeck(slip: Floats, friction: Friction) -> Floats:
    """Return g(s), the coefficient of steady slip [-], Eq. 7."""
    span = friction.static_coefficient - friction.kinetic_coefficient
    steady: Floats = friction.kinetic_coefficient + span * np.exp(-((slip / friction.stribeck_speed) ** 2))
    return steady


def lugre(bristle: Floats, slip: Floats, steady: Floats, friction: Friction) -> tuple[Floats, Floats]:
    """Return friction per normal force [-] and the bristle's rate [m/s], Eq. 6 in coefficient form.

    ``bristle`` [m], ``slip`` [m/s]; ``steady`` is g, the coefficient of steady slip [-].
    """
    rate = slip - friction.bristle_stiffness * np.abs(slip) * bristle / steady
    coefficient = friction.bristle_stiffness * bristle + friction.bristle_damping * rate + friction.viscous * slip
    return coefficient, rate


def pereira_exponent(clearance: float) -> float:
    """Return the exponent n = Y dR^-0.005 [-] of Eq. 22 at a clearance [m]; Pereira et al. 2015 give both branches."""
    gap = clearance * 1e3
    if gap < SMALL_CLEARANCE:
        raise ValueError(f"pocket clearance {clearance:g} m is below {SMALL_CLEARANCE * 1e-3:g} m, where Pereira's law begins")
    factor = 1.51 * np.log(1e3 * gap) ** -0.151 if gap <= LARGE_CLEARANCE else 0.0151 * gap + 1.151
    return float(factor * gap**-0.005)


def pereira(penetration: Floats, clearance: float, length: float, modulus: float) -> Floats:
    """Return the elastic part of the bar force [N], Eq. 22.

    Penetration [m], clearance c_p = dR [m], length L [m] and modulus E* [Pa] are turned into the law's mm and MPa; zero
    where the penetration is not above zero.
    """
    gap, depth = clearance * 1e3, np.maximum(penetration, 0.0) * 1e3
    stiffness = (0.965 * gap + 0.0965) * (length * 1e3) * (modulus * 1e-6) / gap
    force: Floats = stiffness * depth ** pereira_exponent(clearance)
    return force


def impact_loss(rate: Floats, impact_speed: Floats, restitution: float) -> Floats:
    """Return the bracket 1 + 3 (1 - c_e^2)/4 d(delta)/dt / d(delta_minus)/dt of Eq. 22 [-], held within 0 .. 2.

    ``impact_speed`` [m/s] is the rate at first touch; below FLOOR_SPEED that takes its place.
    """
    share = rate / np.maximum(impact_speed, FLOOR_SPEED)
    bracket: Floats = np.clip(1.0 + 0.75 * (1.0 - restitution**2) * share, 0.0, 2.0)
    return bracket

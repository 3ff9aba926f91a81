"""The laws of contact and friction with their equation numbers in Fan et al. 2025; arguments are arrays of equal shape."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import lambertw

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.contact import Friction

FLOOR_SPEED = 1e-3
"""Smallest impact speed used in the damping of a bar contact [m/s]."""

LARGE_CLEARANCE = 0.34954
"""Largest clearance to which the first branch of Pereira's exponent applies [mm]."""


def johnson(penetration: Floats, modulus: float, radius_difference: float) -> tuple[Floats, Floats]:
    """Return normal force [N] and stiffness [N/m] by Eq. 4, solved for the force: F = -pi E* L delta / W_-1(-e delta / (4 dR)).

    ``modulus`` is E* L [N/m], ``radius_difference`` is dR [m]. Force and stiffness are zero unless the penetration [m] is positive.
    """
    closed = penetration > 0.0
    depth = penetration[closed]
    w = lambertw(-math.e * depth / (4.0 * radius_difference), -1).real
    force, stiffness = np.zeros_like(penetration), np.zeros_like(penetration)
    force[closed] = -np.pi * modulus * depth / w
    stiffness[closed] = -np.pi * modulus / (w + 1.0)
    return force, stiffness


def with_loss(force: Floats, stiffness: Floats, loss_time: float, rate: Floats) -> Floats:
    """Return the contact force F + k beta d(delta)/dt with damping, at least zero [N]; the paper has no damping."""
    return np.asarray(np.maximum(force + stiffness * loss_time * rate, 0.0))


def stribeck(slip: Floats, friction: Friction) -> Floats:
    """Return the friction coefficient in steady sliding [-], g(s) = mu_k + (mu_s - mu_k) exp(-(s / v_s)^2), Eq. 7."""
    span = friction.static_coefficient - friction.kinetic_coefficient
    return np.asarray(friction.kinetic_coefficient + span * np.exp(-((slip / friction.stribeck_speed) ** 2)))


def lugre(bristle: Floats, slip: Floats, steady: Floats, friction: Friction) -> tuple[Floats, Floats]:
    """Return the friction force per normal force [-] and the rate of the bristle deflection [m/s], Eq. 6 in coefficient form.

    mu = sigma_0 z + sigma_1 dz/dt + sigma_2 s with dz/dt = s - sigma_0 |s| z / g. ``bristle`` is z [m], ``slip`` is s [m/s],
    ``steady`` is g, the friction coefficient in steady sliding [-].
    """
    rate = slip - relaxation_rate(slip, steady, friction) * bristle
    coefficient = friction.bristle_stiffness * bristle + friction.bristle_damping * rate + friction.viscous * slip
    return coefficient, rate


def relaxation_rate(slip: Floats, steady: Floats, friction: Friction) -> Floats:
    """Return the rate at which a bristle approaches its steady deflection [1/s], sigma_0 |s| / g, as in `lugre`."""
    return np.asarray(friction.bristle_stiffness * np.abs(slip) / steady)


def pereira_exponent(clearance: float) -> float:
    """Return the exponent n = Y dR^-0.005 of Eq. 22 at a clearance dR [m]; Pereira et al. 2015 give both branches of Y.

    Y = 1.51 [ln(1000 dR)]^-0.151 from 0.005 to 0.34954 mm and Y = 0.0151 dR + 1.151 above, with dR in mm.
    """
    gap = clearance * 1e3
    factor = 1.51 * np.log(1e3 * gap) ** -0.151 if gap <= LARGE_CLEARANCE else 0.0151 * gap + 1.151
    return float(factor * gap**-0.005)


def pereira(penetration: Floats, clearance: float, length: float, modulus: float) -> Floats:
    """Return the elastic part of the bar force [N], (0.965 dR + 0.0965) L E* / dR delta^n of Eq. 22.

    Penetration delta [m], clearance c_p = dR [m], length L [m] and modulus E* [Pa] are converted to the law's mm and MPa. The force
    is zero unless the penetration is positive.
    """
    gap, depth = clearance * 1e3, np.maximum(penetration, 0.0) * 1e3
    stiffness = (0.965 * gap + 0.0965) * (length * 1e3) * (modulus * 1e-6) / gap
    return np.asarray(stiffness * depth ** pereira_exponent(clearance))


def impact_loss(rate: Floats, impact_speed: Floats, restitution: float) -> Floats:
    """Return the damping factor 1 + 3 (1 - c_e^2)/4 d(delta)/dt / d(delta_minus)/dt of Eq. 22, limited to 0 .. 2 [-].

    ``impact_speed`` d(delta_minus)/dt is the rate of penetration when the contact closed, at least `FLOOR_SPEED` [m/s].
    """
    share = rate / np.maximum(impact_speed, FLOOR_SPEED)
    return np.asarray(np.clip(1.0 + 0.75 * (1.0 - restitution**2) * share, 0.0, 2.0))

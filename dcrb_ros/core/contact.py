"""Normal forces: Johnson's line contact (Eq. 4 of Fan et al. 2025), the power law beside it, and their loss."""

from __future__ import annotations

import math

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import JOHNSON, Payload


@kernel
def johnson_force(penetration: float, modulus: float, scale: float) -> tuple[float, float]:
    """Return the normal force [N] and its stiffness [N/m] at a penetration [m] above zero.

    Eq. 4 solved for the force: F = -pi E* L delta / W_-1(-e delta / (4 dR)), with ``modulus`` pi E* L [N/m] and
    ``scale`` 4 dR [m]. The branch W_-1 solves w + ln(-w) = l; from w = l - ln(-l) (1 - 1/l) one step of Halley's method leaves a
    relative error of 2e-12.
    """
    log_ratio = 1.0 + math.log(penetration / scale)
    w = log_ratio - math.log(-log_ratio) * (1.0 - 1.0 / log_ratio)
    rest, next_w = w + math.log(-w) - log_ratio, w + 1.0
    w -= 2.0 * rest * w * next_w / (2.0 * next_w * next_w + rest)
    force = -modulus * penetration / w
    return force, -modulus / (w + 1.0)


@kernel
def johnson_penetration(force: float, modulus: float, scale: float) -> float:
    """Return the penetration [m] under a normal force [N] above zero, Eq. 4 as printed."""
    return force / modulus * (math.log(modulus * scale / force) - 1.0)


@kernel
def power_force(penetration: float, coefficient: float, exponent: float) -> tuple[float, float]:
    """Return the normal force [N] and its stiffness [N/m] of F = K delta^n at a penetration [m] above zero."""
    force = coefficient * penetration**exponent
    return force, exponent * force / penetration


@kernel
def normal_force(penetration: float, scale: float, payload: Payload) -> tuple[float, float]:
    """Return normal force [N] and stiffness [N/m] of the contact law chosen, at a penetration [m] above zero."""
    if payload.contact_law == JOHNSON:
        return johnson_force(penetration, payload.contact_modulus, scale)
    return power_force(penetration, payload.power_coefficient, payload.power_exponent)


@kernel
def loss_coefficient(force: float, damping: float, rate: float) -> float:
    """Return the damping [N s/m] of a contact of elastic ``force`` [N] that penetrates at ``rate`` [m/s].

    Where the contact opens so fast that the loss would outweigh the force, it is cut to what makes the sum zero: a
    contact never pulls.
    """
    if force + damping * rate < 0.0:
        return -force / rate
    return damping

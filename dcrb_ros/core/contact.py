"""Normal forces: Johnson's line contact (Eq. 4 of Fan et al. 2025), the power law beside it, and their loss."""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import logarithm
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import JOHNSON, Payload

LEAST_PENETRATION = 1e-15
"""What stands for the penetration of an open contact, so that the law can be written without a branch [m]."""


@kernel
def line_contact(log_ratio: float) -> tuple[float, float]:
    """Return numerator and denominator of -W_-1(-e^l) at l = ``log_ratio``, the lower branch of the Lambert function.

    A rational fit over -40 .. -4, right to 1e-13 (`benchmarks/fit_line_contact.py`); above -4, where a roller would be pressed in by
    one part in forty of its radius, the value at -4.
    """
    t = (min(log_ratio, -4.0) + 22.0) * (1.0 / 18.0)
    t2 = t * t
    t4 = t2 * t2
    above = (25.227952610343658 - 111.70804449222039 * t) + t2 * (209.02017336824925 - 214.28786416771893 * t)
    above += t4 * ((130.31719216890709 - 47.426067396990194 * t) + t2 * (9.8533827349380200 - 1.0261529188664917 * t))
    above += t4 * t4 * 0.037774529454882129
    below = (1.0 - 3.6850037902163191 * t) + t2 * (5.5589025113215732 - 4.4000992016805178 * t)
    below += t4 * ((1.9413959503750688 - 0.46528432479890793 * t) + t2 * (0.053636784985261526 - 0.0020961313201773434 * t))
    return above, below


@kernel
def johnson_force(penetration: float, modulus: float, scale: float) -> tuple[float, float]:
    """Return the normal force [N] and its stiffness [N/m] at a penetration [m] above zero.

    Eq. 4 solved for the force: F = -pi E* L delta / W_-1(-e delta / (4 dR)), with ``modulus`` pi E* L [N/m] and
    ``scale`` 4 dR [m]; its slope is -pi E* L / (W_-1 + 1).
    """
    above, below = line_contact(1.0 + logarithm(penetration) - logarithm(scale))
    share = modulus * below / (above * (above - below))
    return penetration * share * (above - below), share * above


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
    return -force / rate if force + damping * rate < 0.0 else damping

"""Conformal contact of a roller with its bar and of a cage with its land (Pereira et al. 2015, Eq. 22 of Fan et al. 2025)."""

from __future__ import annotations

import math

from dcrb_ros.core.contact import power_force
from dcrb_ros.core.jit import kernel

LEAST_IMPACT = 1e-3
"""Least impact speed that the loss is referred to [m/s]; a contact that closes gently would otherwise be all loss."""
MOST_GAIN = 2.0
"""Largest factor of the loss on the elastic force [-]; the smallest is 0, a contact never pulls."""
LOWER_BRANCH_END = 0.34954
"""Clearance at which the exponent's two branches meet [mm]."""


def conformal_law(clearance: float, length: float, modulus: float) -> tuple[float, float]:
    """Return coefficient [N/m^n] and exponent n [-] of F = K delta^n, Eq. 22 without its loss.

    ``clearance`` dR [m] from 5 um up, ``length`` L [m], ``modulus`` E* [Pa]; the law itself is in mm, MPa and N. The
    paper leaves out the branch above 0.34954 mm; it is continuous at the join.
    """
    gap, width, stiffness = clearance * 1e3, length * 1e3, modulus * 1e-6
    y = 1.51 * math.log(1000.0 * gap) ** -0.151 if gap <= LOWER_BRANCH_END else 0.0151 * gap + 1.151
    exponent = y * gap**-0.005
    return (0.965 * gap + 0.0965) * width * stiffness / gap * 1000.0**exponent, exponent


@kernel
def conformal_contact(
    penetration: float, rate: float, impact: float, coefficient: float, exponent: float, impact_loss: float
) -> tuple[float, float, float, float]:
    """Return elastic force [N], stiffness [N/m], damping [N s/m] and the latched impact speed [m/s] of Eq. 22.

    ``rate`` is the speed of penetration [m/s], ``impact`` the speed latched when the contact closed, 0 if it closes now.
    The damping is what makes force + damping * rate the law's force, its factor held within [0, 2].
    """
    force, stiffness = power_force(penetration, coefficient, exponent)
    if impact == 0.0:
        impact = max(rate, LEAST_IMPACT)
    damping = impact_loss * force / impact
    gain = damping * rate
    if gain < -force:
        damping = -force / rate
    elif gain > (MOST_GAIN - 1.0) * force:
        damping = (MOST_GAIN - 1.0) * force / rate
    return force, stiffness, damping, impact

"""Conformal contact of a roller with its bar and of a cage with its land (Pereira et al. 2015, Eq. 22 of Fan et al. 2025)."""

from __future__ import annotations

from dcrb_ros.core.contact import power_force
from dcrb_ros.core.jit import kernel

LEAST_IMPACT = 1e-3
"""Least impact speed that the loss is referred to [m/s]; a contact that closes gently would otherwise be all loss."""
MOST_GAIN = 2.0
"""Largest factor of the loss on the elastic force [-]; the smallest is 0, a contact never pulls."""


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

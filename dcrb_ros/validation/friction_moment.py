"""The friction moment of cylindrical roller bearings by the models of SKF and of Palmgren, to compare the simulated one with.

SKF, *Rolling bearings*, section "Friction": M = phi_ish phi_rs G_rr (nu n)^0.6 + G_sl mu_sl, here of a radial load without seals and drag.
"""

from __future__ import annotations

import math

ROLLING = 1.40e-6
"""R_1 of a caged bearing of the dimension series 22, whose rollers have the size of the default bearing's: 30 mm by 48 mm."""
SLIDING = 0.0015
"""S_2 of cylindrical roller bearings."""
REPLENISHMENT = 6e-8
"""K_rs of grease: the rollers displace it faster than it flows back."""
GEOMETRY = 5.1
"""K_Z of caged cylindrical roller bearings."""
SLIDING_FRICTION = 0.02
"""mu_sl of cylindrical roller bearings with a full film [-]."""
BOUNDARY_FRICTION = 0.15


PALMGREN_VISCOUS = {"grease": 0.8, "vg100": 3.0, "vg220": 3.0, "custom": 3.0}
"""f_0 of Palmgren for cylindrical roller bearings with a cage: 0.6 to 1 for grease, 2.2 to 4 for an oil bath."""
PALMGREN_LOAD = 0.0003
"""f_1 of Palmgren for cylindrical roller bearings with a cage, 0.0002 to 0.0004."""
LEAST_FLOW = 2000.0
"""Product of viscosity [mm^2/s] and speed [1/min] below which Palmgren's viscous moment is constant."""


def palmgren_moment(bore: float, outside: float, load: float, speed: float, viscosity: float, lubricant: str = "grease") -> float:
    """Return the friction moment of a single-row bearing by Palmgren [N m]; see `friction_moment`.

    M = 1e-7 f_0 (nu n)^(2/3) d_m^3 + f_1 P d_m in N mm, with nu in mm^2/s, n in 1/min and d_m in mm (Palmgren 1957; Harris, *Rolling
    Bearing Analysis*, gives the ranges of f_0 and f_1, whose middles are taken).
    """
    mean, rpm = 1e3 * 0.5 * (bore + outside), abs(speed) * 30.0 / math.pi
    viscous = 1e-7 * PALMGREN_VISCOUS[lubricant] * max(viscosity * rpm, LEAST_FLOW) ** (2.0 / 3.0) * mean**3
    return float(1e-3 * (viscous + PALMGREN_LOAD * load * mean))


def friction_moment(bore: float, outside: float, load: float, speed: float, viscosity: float) -> float:
    """Return the friction moment of a single-row bearing [N m].

    Parameters
    ----------
    bore, outside
        Diameters of bore and outside [m].
    load
        Radial load [N].
    speed
        Speed of the inner ring [rad/s].
    viscosity
        Kinematic viscosity of oil or base oil at the bearing's temperature [mm^2/s].
    """
    d, big, rpm = 1e3 * bore, 1e3 * outside, abs(speed) * 30.0 / math.pi
    mean = 0.5 * (d + big)
    flow = viscosity * rpm
    shear = 1.0 / (1.0 + 1.84e-9 * (rpm * mean) ** 1.28 * viscosity**0.64)
    starved = math.exp(-REPLENISHMENT * flow * (d + big) * math.sqrt(GEOMETRY / (2.0 * (big - d))))
    rolling = shear * starved * ROLLING * mean**2.41 * load**0.31 * flow**0.6
    boundary = math.exp(-2.6e-8 * flow**1.4 * mean)
    sliding = SLIDING * mean * load * (boundary * BOUNDARY_FRICTION + (1.0 - boundary) * SLIDING_FRICTION)
    return float(1e-3 * (rolling + sliding))

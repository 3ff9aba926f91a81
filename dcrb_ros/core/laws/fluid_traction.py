"""Traction of an oil film: Bair and Winer 1979, shear rate against limiting stress, isothermal at the mean pressure.

    mu_fl(s) = mu_L (1 - exp(-|s|/s_0)),   s_0 = mu_L p h/eta_p(p),   p = F/(2 b L)

Asperities carry the share phi of the load with the coefficient mu_b:

    g(s) = phi mu_b + (1 - phi) mu_fl(s)
"""

from __future__ import annotations

from dcrb_ros.core.arithmetic import exponential, logarithm
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.viscosity import ROELANDS_PRESSURE

LEAST_SLIP = 1e-12
"""Least slip at which g and |s|/g are evaluated [m/s]."""
VISCOUS = 1e-3
"""Slip over s_0 below which a series replaces 1 - exp(-x), of which few digits would be left [-]."""
MOST = 600.0
"""Largest logarithm of a viscosity ratio [-]; a stiffer film does not slide."""


@kernel
def characteristic_slip(pressure: float, film: float, limiting: float, viscosity: float, offset: float, exponent: float) -> float:
    """Return s_0 [m/s] at a mean pressure [Pa] with a film [m].

    ``limiting`` is mu_L [-], ``viscosity`` eta [Pa s], ``offset`` ln eta + 9.67 and ``exponent`` Z of Roelands [-].
    """
    product = exponent * logarithm(1.0 + pressure * (1.0 / ROELANDS_PRESSURE))
    stiffening = offset * (exponential(product) - 1.0)
    return limiting * pressure * film * exponential(-min(stiffening, MOST)) / viscosity


@kernel
def fluid_coefficient(slip: float, characteristic: float, limiting: float) -> float:
    """Return mu_fl [-] at a slip above zero [m/s]."""
    ratio = slip / characteristic
    series = ratio * (1.0 - ratio * (0.5 - ratio * (1.0 / 6.0)))
    return limiting * (series if ratio < VISCOUS else 1.0 - exponential(-ratio))

"""Thickness of the oil film in a line contact that rolls, and the share of the load that asperities carry.

With the dimensionless speed U = eta u/(E' R), material G = alpha E' and load W = F/(E' R L), where E' = E/(1 - nu^2):

    central   h_c = 3.06 R U^0.69 G^0.56 W^-0.10   (Dowson and Toyoda 1979)
    minimum   h_m = 2.65 R U^0.70 G^0.54 W^-0.13   (Dowson and Higginson 1966)

both times phi_T = 1/(1 + 0.1 L_t^0.64), the heating of the inlet (Wilson and Sheu 1983) with L_t = beta eta u^2/k_f. A layer of the
thickness H starves the contact (Chevalier et al. 1998, J. Tribol. 120:126): h = h_ff/sqrt(1 + (h_ff/H)^2). Asperities carry the share
exp(-1.8 Lambda^1.2) of the load, Lambda = h/sigma (Zhou and Hoeprich 1991).
"""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import exponential, logarithm
from dcrb_ros.core.jit import kernel

LEAST_FORCE = 1.0
"""Least force for which the formulas are evaluated [N]; a contact under less is a rigid one."""
LEAST_RATIO = 1e-9
"""Least ratio of film and roughness, for the logarithm [-]."""
ASPERITY_FACTOR, ASPERITY_EXPONENT = 1.8, 1.2
"""B and C of Zhou and Hoeprich [-]."""


@kernel
def power(base: float, exponent: float) -> float:
    """Return a power of a base above zero whose logarithm times the exponent is within -700 and 700 [-]."""
    return exponential(exponent * logarithm(base))


@kernel
def inlet_heating(number: float) -> float:
    """Return phi_T [-] of a thermal loading L_t [-]."""
    return 1.0 / (1.0 + 0.1 * power(max(number, 1e-30), 0.64))


@kernel
def central_per_load(speed: float, material: float, modulus: float, radius: float, length: float) -> float:
    """Return h_c F^0.10 [m N^0.10] for U = ``speed`` and G = ``material`` [-]; ``modulus`` is E' [Pa], lengths in [m]."""
    return 3.06 * radius * power(speed, 0.69) * power(material, 0.56) * power(modulus * radius * length, 0.10)


@kernel
def minimum_per_load(speed: float, material: float, modulus: float, radius: float, length: float) -> float:
    """Return h_m F^0.13 [m N^0.13]; see `central_per_load`."""
    return 2.65 * radius * power(speed, 0.70) * power(material, 0.54) * power(modulus * radius * length, 0.13)


@kernel
def starved(flooded: float, layer: float) -> float:
    """Return the film thickness [m] of a contact that a layer [m] feeds, from the flooded one [m]."""
    return flooded * layer / math.sqrt(flooded * flooded + layer * layer)


@kernel
def asperity_share(ratio: float) -> float:
    """Return the share of the load on asperities [-] at a ratio Lambda of film thickness and roughness [-]."""
    return exponential(-ASPERITY_FACTOR * power(max(ratio, LEAST_RATIO), ASPERITY_EXPONENT))

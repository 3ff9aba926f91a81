"""Resistance of an oil film to rolling: Biboulet and Houpert 2010, Part 1 (DOI 10.1243/13506501JET790), Eqs. 14 and 40 to 44.

With U = 2 eta u/(E' R), W = F/(E' R L) and M = W/sqrt(U); the factor 2 in U is this paper's:

    F_R = E' R L 1.42 sqrt(U W)/(1 + (1.4/1.45 sqrt(M))^10)^(1/10)

A starved inlet reduces it by (S^2 + 162.8 S)/(S^2 + 193.1 S + 1257), S the meniscus over the minimum film, its heating by
1/(1 + 0.29 L_t^0.78) (Aihara 1987). The film drags both surfaces against their motion by F_R and pushes both bodies by 2 F_R R/r along it,
so that the power lost is 2 F_R |V|.
"""

from __future__ import annotations

import math

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.film_thickness import power

REVERSAL_SPEED = 0.05
"""Speed of rolling below which the resistance fades, as it changes its sign with the direction [m/s]."""
JOIN = (1.4 / 1.45) ** 2
"""Factor on M in the change from light to heavy load [-]."""


@kernel
def resistance_scale(speed: float, modulus: float, radius: float, length: float) -> float:
    """Return 1.42 E' R L U^(3/4) [N], for U = ``speed`` [-]; the resistance of light loads is this times sqrt(M)."""
    return 1.42 * modulus * radius * length * power(speed, 0.75)


@kernel
def flooded_resistance(scale: float, ratio: float) -> float:
    """Return F_R [N] for M = ``ratio`` [-]."""
    join = JOIN * ratio
    square = join * join
    return scale * math.sqrt(ratio) * power(1.0 + square * square * join, -0.1)


@kernel
def starvation(meniscus: float) -> float:
    """Return the factor of a starved inlet [-] at S = ``meniscus`` [-]."""
    return (meniscus + 162.8) * meniscus / ((meniscus + 193.1) * meniscus + 1257.0)


@kernel
def inlet_cooling(number: float) -> float:
    """Return the factor of the heated inlet [-] at a thermal loading L_t [-]."""
    return 1.0 / (1.0 + 0.29 * power(max(number, 1e-30), 0.78))


@kernel
def directed(speed: float) -> float:
    """Return the sign of a speed of rolling [m/s], smoothed about standstill [-]."""
    return speed / math.sqrt(speed * speed + REVERSAL_SPEED * REVERSAL_SPEED)

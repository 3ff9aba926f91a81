"""Law of the conformal contacts of bar and land (Pereira et al. 2015, Eq. 22 of Fan et al. 2025), without its loss."""

from __future__ import annotations

import math

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


def power_stiffness(force: float, coefficient: float, exponent: float) -> float:
    """Return the slope of F = K delta^n [N/m] under a force [N]."""
    return float(exponent * force ** (1.0 - 1.0 / exponent) * coefficient ** (1.0 / exponent))

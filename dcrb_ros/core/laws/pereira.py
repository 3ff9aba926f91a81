"""Conformal contact of a roller with its bar and of a cage with its land: Pereira et al. 2015, as Eq. 22 of Fan et al. 2025.

    F = K delta^n (1 + 3 (1 - c_e^2)/4 * d(delta)/dt / impact speed)

Its strikes last only a few steps. So the force over a step is the difference of the contact's potential between the ends of the step over
the way between them (a discrete gradient; Gonzalez 1996, J. Nonlinear Sci. 6), not the law's value in the middle: a strike without loss
then gives back the energy that it took, and the contact may close and open anywhere within a step.
"""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import LEAST_PENETRATION, exponential, logarithm
from dcrb_ros.core.jit import kernel

LOWER_BRANCH_END = 0.34954
"""Clearance at which the exponent's two branches meet [mm]."""
LEAST_IMPACT_SPEED = 1e-3
"""Least impact speed that the loss is referred to [m/s]; a contact that closes gently would otherwise be all loss."""
LARGEST_GAIN = 2.0
"""Largest factor of the loss on the elastic force [-]; the smallest is 0, a contact never pulls."""
SMALL_CHANGE = 1e-3
"""Change of a penetration, as a share of it, below which the mean of the forces at both ends replaces the difference of the potential."""


def pereira_coefficients(clearance: float, length: float, modulus: float) -> tuple[float, float]:
    """Return coefficient K [N/m^n] and exponent n [-] of the elastic force.

    ``clearance`` dR [m] from 5 um up, ``length`` L [m], ``modulus`` E* [Pa]; the law itself is in mm, MPa and N. The
    paper leaves out the branch above 0.34954 mm; it is continuous at the join.
    """
    gap, width, stiffness = clearance * 1e3, length * 1e3, modulus * 1e-6
    y = 1.51 * math.log(1000.0 * gap) ** -0.151 if gap <= LOWER_BRANCH_END else 0.0151 * gap + 1.151
    exponent = y * gap**-0.005
    return (0.965 * gap + 0.0965) * width * stiffness / gap * 1000.0**exponent, exponent


def pereira_stiffness(force: float, coefficient: float, exponent: float) -> float:
    """Return the slope of F = K delta^n [N/m] under a force [N]."""
    return float(exponent * force ** (1.0 - 1.0 / exponent) * coefficient ** (1.0 / exponent))


@kernel
def impact_damping(force: float, rate: float, impact: float, impact_loss: float) -> float:
    """Return the damping [N s/m] of a conformal contact of elastic ``force`` [N] that closed at ``impact`` [m/s].

    ``rate`` is the speed of penetration [m/s]. Force + damping * rate is the law's force, its factor limited to 0 .. 2.
    """
    damping = impact_loss * force / impact
    gain = damping * rate
    most = (LARGEST_GAIN - 1.0) * force
    limited = max(min(gain, most), -force)
    return damping if gain == limited else limited / rate


@kernel
def mean_force(first: float, last: float, coefficient: float, exponent: float) -> tuple[float, float]:
    """Return the mean force [N] of F = K delta^n on the way from a penetration to another [m], and its slope over the last [N/m].

    Penetrations below zero are a gap, without force; they lie below 1 m.
    """
    deep, deeper = max(first, LEAST_PENETRATION), max(last, LEAST_PENETRATION)
    before, after = coefficient * exponential(exponent * logarithm(deep)), coefficient * exponential(exponent * logarithm(deeper))
    before, after = before if first > LEAST_PENETRATION else 0.0, after if last > LEAST_PENETRATION else 0.0
    way, share = last - first, 1.0 / (exponent + 1.0)
    still = abs(way) <= SMALL_CHANGE * max(deep, deeper)
    by_way = 1.0 / (1.0 if still else way)
    mean = (after * deeper - before * deep) * share * by_way
    slope = (after - mean) * by_way
    return 0.5 * (before + after) if still else mean, 0.5 * exponent * after / deeper if still else slope


@kernel
def step_force(
    begin: float, rate: float, last: float, mobility: float, step: float, coefficient: float, exponent: float
) -> tuple[float, float, float]:
    """Return mean elastic force [N], its slope over the mean speed of penetration [N s/m] and that speed [m/s] over a step.

    ``begin`` is the penetration at its beginning [m], ``rate`` the mean speed if the force ``last`` [N] of the last step
    went on, ``mobility`` how the force changes it [m/(N s)]: half the step over the bodies' reduced mass.
    """
    expected, force, slope, change = rate, 0.0, 0.0, 0.0
    # The way depends on the force and the force on the way: one step of Newton's method.
    for _ in range(2):
        rate += change
        force, slope = mean_force(begin, begin + step * rate, coefficient, exponent)
        change = (expected - rate + mobility * (last - force)) / (1.0 + mobility * step * slope)
    return force, step * slope, rate

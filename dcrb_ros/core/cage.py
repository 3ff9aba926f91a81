"""Conformal contact of a roller with its bar and of a cage with its land (Pereira et al. 2015, Eq. 22 of Fan et al. 2025).

Its strikes last but a few steps. So the force over a step is the difference of the contact's potential between the step's ends over
the way between them (a discrete gradient; Gonzalez 1996, J. Nonlinear Sci. 6), not the law's value in the middle: a strike without
loss then gives back what it took, and the contact may close and open anywhere within a step.
"""

from __future__ import annotations

from dcrb_ros.core.arithmetic import exponential, logarithm
from dcrb_ros.core.contact import LEAST_PENETRATION
from dcrb_ros.core.jit import kernel

LEAST_IMPACT = 1e-3
"""Least impact speed that the loss is referred to [m/s]; a contact that closes gently would otherwise be all loss."""
MOST_GAIN = 2.0
"""Largest factor of the loss on the elastic force [-]; the smallest is 0, a contact never pulls."""
FEW = 1e-3
"""Change of a penetration, as a share of it, below which the mean of the forces at both ends stands for the potential's difference."""


@kernel
def impact_damping(force: float, rate: float, impact: float, impact_loss: float) -> float:
    """Return the damping [N s/m] of a conformal contact of elastic ``force`` [N] that closed at ``impact`` [m/s], Eq. 22.

    ``rate`` is the speed of penetration [m/s]. Force + damping * rate is the law's force, its factor held within [0, 2].
    """
    damping = impact_loss * force / impact
    gain = damping * rate
    most = (MOST_GAIN - 1.0) * force
    held = max(min(gain, most), -force)
    return damping if gain == held else held / rate


@kernel
def mean_force(first: float, last: float, coefficient: float, exponent: float) -> tuple[float, float]:
    """Return the mean force [N] of F = K delta^n on the way from a penetration to another [m], and its slope over the last [N/m].

    Penetrations below zero are a gap, without force; they lie below 1 m.
    """
    deep, deeper = max(first, LEAST_PENETRATION), max(last, LEAST_PENETRATION)
    before, after = coefficient * exponential(exponent * logarithm(deep)), coefficient * exponential(exponent * logarithm(deeper))
    before, after = before if first > LEAST_PENETRATION else 0.0, after if last > LEAST_PENETRATION else 0.0
    way, share = last - first, 1.0 / (exponent + 1.0)
    still = abs(way) <= FEW * max(deep, deeper)
    by_way = 1.0 / (1.0 if still else way)
    mean = (after * deeper - before * deep) * share * by_way
    slope = (after - mean) * by_way
    return 0.5 * (before + after) if still else mean, 0.5 * exponent * after / deeper if still else slope


@kernel
def strike(
    begin: float, rate: float, known: float, yielding: float, step: float, coefficient: float, exponent: float
) -> tuple[float, float, float]:
    """Return mean elastic force [N], its slope over the mean speed of penetration [N s/m] and that speed [m/s] over a step.

    ``begin`` is the penetration at its beginning [m], ``rate`` the speed expected if the force ``known`` [N] of the last step
    went on, ``yielding`` what a force takes off it [m/(N s)]: half the step over the bodies' reduced mass.
    """
    expected, force, slope, change = rate, 0.0, 0.0, 0.0
    # How far it gets hangs on the force, and this on how far: one step of Newton's method.
    for _ in range(2):
        rate += change
        force, slope = mean_force(begin, begin + step * rate, coefficient, exponent)
        change = (expected - rate + yielding * (known - force)) / (1.0 + yielding * step * slope)
    return force, step * slope, rate

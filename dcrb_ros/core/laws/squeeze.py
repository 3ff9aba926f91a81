"""Oil between a roller and a raceway that do not touch: its resistance to approach, and the lift of its wedge.

Squeeze of a rigid cylinder against a plane, both sides wet, from Reynolds' equation for a parabolic gap:

    c(g) = A g^(-3/2),   A = 3 sqrt(2) pi eta L R^(3/2)

The layer ends at a gap H, the film cannot be thinner than a floor h_s:

    c(g) = A (q^(-3/2) - H^(-3/2)) for g < H,   q = max(g, h_s)

Film and elastic contact lie in series, so that no damping may exceed the impedance Z = sqrt(m k) of a blow:

    h_s = max(h, (Z/A + H^(-3/2))^(-2/3))

Wedge of two surfaces that roll (Martin 1916), with a factor for the end of the layer that is a choice:

    F_w = 4.9 eta u R L/q (1 - q/H)^2,   q = max(g, h)
"""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import logarithm
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.film_thickness import power

LEAST_WAY = 1e-13
"""Way over a step below which the damping at the gap replaces its mean over the way [m]."""


def squeeze_coefficient(viscosity: float, length: float, radius: float) -> float:
    """Return A [N s m^(1/2)] of a viscosity [Pa s], a length of contact and a reduced radius [m]."""
    return 3.0 * math.sqrt(2.0) * math.pi * viscosity * length * radius * math.sqrt(radius)


@kernel
def squeeze_floor(coefficient: float, impedance: float, layer: float) -> float:
    """Return the gap [m], below the end of the layer, at which c(g) reaches the impedance [N s/m]."""
    return power(impedance / coefficient + 1.0 / (layer * math.sqrt(layer)), -2.0 / 3.0)


@kernel
def squeeze_impulse(gap: float, coefficient: float, floor: float, layer: float) -> float:
    """Return the impulse per speed that the layer still has at a gap [m]: the integral of c(g) from the gap to the layer's end [N s]."""
    held = min(gap, layer)
    q = max(held, floor)
    by_root = 1.0 / math.sqrt(layer)
    by_layer = by_root * by_root * by_root
    whole = coefficient * (2.0 / math.sqrt(q) - 3.0 * by_root + q * by_layer)
    return whole + coefficient * (1.0 / (q * math.sqrt(q)) - by_layer) * (q - held)


@kernel
def squeeze_at(gap: float, coefficient: float, floor: float, layer: float) -> float:
    """Return c(g) [N s/m] at a gap [m]."""
    q, by_root = max(min(gap, layer), floor), 1.0 / math.sqrt(layer)
    return coefficient * (1.0 / (q * math.sqrt(q)) - by_root * by_root * by_root)


@kernel
def squeeze_near(gap: float, coefficient: float, floor: float, film: float, layer: float) -> float:
    """Return c(g) [N s/m] as `squeeze_at`, by the inverse of the gap that `wedge_force` uses, too; the ``film`` is below the floor [m]."""
    by_q, by_root = min(1.0 / min(max(gap, film), layer), 1.0 / floor), 1.0 / math.sqrt(layer)
    # Beyond the layer rounding would leave some 1e-15 of it: enough for a contact to count as closed.
    return coefficient * (max(by_q * math.sqrt(by_q) - by_root * by_root * by_root, 0.0) if gap < layer else 0.0)


@kernel
def squeeze_damping(gap: float, way: float, coefficient: float, floor: float, layer: float) -> float:
    """Return the mean damping [N s/m] of a step that begins at a gap and ends ``way`` nearer [m].

    The mean is the difference of the impulse over the way, so that the momentum taken does not depend on the step. When the gap opens the
    film cavitates, and there is no damping.
    """
    after = gap - way
    still = abs(way) <= LEAST_WAY
    by_way = 1.0 / (1.0 if still else way)
    mean = (squeeze_impulse(after, coefficient, floor, layer) - squeeze_impulse(gap, coefficient, floor, layer)) * by_way
    damping = squeeze_at(gap, coefficient, floor, layer) if still else mean
    # Not below zero by rounding: a film takes energy only.
    return max(damping, 0.0) if way > 0.0 and coefficient > 0.0 else 0.0


@kernel
def wedge_force(gap: float, lift: float, film: float, layer: float) -> tuple[float, float]:
    """Return the lift of the wedge [N] and its stiffness [N/m] at a gap [m]; ``lift`` is 4.9 eta u R L [N m]."""
    q = min(max(gap, film), layer)
    share, by_q = 1.0 - q / layer if gap < layer else 0.0, 1.0 / q
    force = lift * by_q * share * share
    slope = force * by_q + 2.0 * lift * by_q * share / layer
    return force, slope if film < gap < layer else 0.0


@kernel
def wedge_energy(gap: float, lift: float, film: float, layer: float) -> float:
    """Return the integral of the wedge's lift from a gap to the layer's end [J]."""
    q = min(max(gap, film), layer)
    ratio = q / layer
    below = wedge_force(q, lift, film, layer)[0] * (q - min(gap, q))
    return lift * (2.0 * ratio - 1.5 - 0.5 * ratio * ratio - logarithm(ratio)) + below

"""The normal force of a raceway contact over a step, as a straight line over its mean speed of approach.

A contact that is closed during the whole step takes the law's force in the middle of the step, and a mass of h^2 k/12 is added, which gives
leapfrog the right frequency to fourth order. The midpoint force misrepresents a step in which the contact opens or closes: a strike lasts
only a few steps, and the energy error reached 10 %, depending on when in the step the contact closed. Such a contact takes the mean force
over its way, the difference of the potential divided by the way (a discrete gradient; Gonzalez 1996, J. Nonlinear Sci. 6), with the same
correction of the mass. `docs/explanation/solver.md` derives both.
"""

from __future__ import annotations

from dcrb_ros.core.arithmetic import LEAST_PENETRATION
from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.laws.johnson import johnson_energy, johnson_force
from dcrb_ros.core.laws.loss import loss_coefficient
from dcrb_ros.core.laws.power import power_energy, power_force
from dcrb_ros.core.payload import JOHNSON, Payload

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""
MEAN_DISPERSION = 1.0 / 6.0
"""The mean force over a straight way corresponds to a mass of h^2 k/4; h^2 k/6 is taken off to leave h^2 k/12."""


@kernel
def normal_force(penetration: float, scale: float, payload: Payload) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] of the contact law chosen, at a penetration [m] above zero."""
    if payload.contact_law == JOHNSON:
        return johnson_force(penetration, payload.contact_modulus, scale)
    return power_force(penetration, payload.power_coefficient, payload.power_exponent)


@piece
def elastic(penetration: float, scale: float, johnson: bool, payload: Payload) -> tuple[float, float]:
    """Return elastic force [N] and stiffness [N/m] at a penetration [m]; zero where the contact is open.

    ``johnson`` chooses the law once for a whole loop.
    """
    closed = max(penetration, LEAST_PENETRATION)
    if johnson:
        force, stiffness = johnson_force(closed, payload.contact_modulus, scale)
    else:
        force, stiffness = power_force(closed, payload.power_coefficient, payload.power_exponent)
    return force if penetration > 0.0 else 0.0, stiffness if penetration > 0.0 else 0.0


@piece
def potential(penetration: float, force: float, johnson: bool, payload: Payload) -> float:
    """Return the energy [J] of a contact of penetration [m] under its elastic ``force`` [N]."""
    if johnson:
        return johnson_energy(penetration, force, payload.contact_modulus)
    return power_energy(penetration, force, payload.power_exponent)


@piece
def damping_of(force: float, stiffness: float, share: float, payload: Payload) -> float:
    """Return the damping [N s/m] of a contact that is closed for a ``share`` of the step [-]."""
    return stiffness * payload.loss_time + (payload.contact_damping * share if force > 0.0 else 0.0)


@piece
def force_line(
    force: float, mean: float, slope: float, damping: float, closing: float, sink: float
) -> tuple[float, float, float, float, float]:
    """Return the line force_offset [N] + force_slope [N s/m] * approach, then expected force [N], its damping [N s/m] and ``closing``.

    ``mean`` [N] is the elastic force at the speed of penetration ``closing`` [m/s], ``slope`` its slope there, ``force`` [N] that which
    the damping must not outweigh: a contact never pulls. ``sink`` is the speed at which the floor of a notch falls away [m/s].
    """
    damping = loss_coefficient(force, damping, closing)
    return mean - slope * closing - (slope + damping) * sink, slope + damping, force + damping * closing, damping, closing


@piece
def lasting_line(
    force: float, stiffness: float, closing: float, before: float, sink: float, payload: Payload
) -> tuple[float, float, float, float, float]:
    """Return the `force_line` of a contact of elastic ``force`` [N] and ``stiffness`` [N/m] in the middle of the step.

    ``closing`` is the speed of penetration expected, ``before`` that before the step [m/s].
    """
    slope = 2.0 * DISPERSION * payload.step * stiffness
    return force_line(force, force + slope * (closing - before), slope, damping_of(force, stiffness, 1.0, payload), closing, sink)


@piece
def crosses(penetration: float, closing: float, before: float, step: float) -> bool:
    """Return whether a contact closes or opens within a step: see `crossing_line`."""
    begin = penetration - 0.5 * step * before
    return (begin > 0.0) != (begin + step * closing > 0.0)


@piece
def crossing_line(
    penetration: float, closing: float, before: float, sink: float, last: float, mobility: float, scale: float, payload: Payload
) -> tuple[float, float, float, float, float]:
    """Return the `force_line` of a contact that closes or opens within the step.

    ``penetration`` [m] is that in the middle of the step, reached with the speed of penetration ``before`` [m/s]. ``closing`` is the mean
    speed if the force ``last`` [N] of the last step went on [m/s], ``mobility`` how the force changes it [m/(N s)].
    """
    h, johnson = payload.step, payload.contact_law == JOHNSON
    begin = penetration - 0.5 * h * before
    force, _ = elastic(begin, scale, johnson, payload)
    energy, deep = potential(max(begin, 0.0), force, johnson, payload), max(begin, 0.0)
    mean = slope = damping = change = 0.0
    # The way depends on the force and the force on the way: one step of Newton's method.
    for _ in range(2):
        closing += change
        way = h * closing
        by_way = 1.0 / way if abs(way) > LEAST_PENETRATION else 0.0
        after, _ = elastic(begin + way, scale, johnson, payload)
        deeper = max(begin + way, 0.0)
        over = (potential(deeper, after, johnson, payload) - energy) * by_way
        secant = max((after - force) * by_way, 0.0)
        correction = 2.0 * MEAN_DISPERSION * h * secant
        mean, slope = max(over - correction * (closing - before), 0.0), h * (after - over) * by_way - correction
        damping = damping_of(mean, secant, (deeper - deep) * by_way, payload)
        change = mobility * (last - mean - damping * closing) / (1.0 + mobility * (slope + damping))
    return force_line(mean, mean, slope, damping, closing, sink)

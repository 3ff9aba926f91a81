"""The normal force of a raceway contact over a step, as a straight line over its mean speed of approach.

A contact that is closed all the step takes the law's value in the middle, and a mass of h^2 k/12 goes with it, which gives leapfrog the
right frequency to fourth order. One that closes or opens within the step has no value in the middle that stands for the step: a strike
lasts but a few steps, and a tenth of its energy hung on when within a step it began. Such a contact takes the mean of the force over the
way, the difference of its potential over it (a discrete gradient; Gonzalez 1996, J. Nonlinear Sci. 6), and the same mass in its terms.
"""

from __future__ import annotations

from dcrb_ros.core.contact import LEAST_PENETRATION, johnson_force, loss_coefficient, power_force
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import JOHNSON, Payload

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""
BEND = 1.0 / 6.0
"""What that makes of the mean over a straight way, which stands for a mass of h^2 k/4: h^2 k/6 is taken off."""


@piece
def elastic(depth: float, scale: float, johnson: bool, payload: Payload) -> tuple[float, float]:
    """Return elastic force [N] and stiffness [N/m] at a penetration [m]; zero where the contact is open.

    ``johnson`` chooses the law once for a whole loop.
    """
    closed = max(depth, LEAST_PENETRATION)
    if johnson:
        force, stiffness = johnson_force(closed, payload.contact_modulus, scale)
    else:
        force, stiffness = power_force(closed, payload.power_coefficient, payload.power_exponent)
    return force if depth > 0.0 else 0.0, stiffness if depth > 0.0 else 0.0


@piece
def potential(depth: float, force: float, johnson: bool, payload: Payload) -> float:
    """Return the energy [J] of a contact of penetration ``depth`` [m] under its elastic ``force`` [N]."""
    if johnson:
        return 0.5 * force * depth - force * force / (4.0 * payload.contact_modulus)
    return force * depth / (payload.power_exponent + 1.0)


@piece
def loss_law(force: float, stiffness: float, share: float, payload: Payload) -> float:
    """Return the damping [N s/m] of a contact that is closed for a ``share`` of the step [-]."""
    return stiffness * payload.loss_time + (payload.contact_damping * share if force > 0.0 else 0.0)


@piece
def line(force: float, mean: float, give: float, loss: float, closing: float, sink: float) -> tuple[float, float, float, float, float]:
    """Return push [N], give [N s/m], force expected [N], its damping [N s/m] and speed: the force is push + give * approach.

    ``mean`` [N] is the elastic force at the speed ``closing`` [m/s] at which ``give`` is its slope, ``force`` [N] the law's, which a
    loss cannot outweigh: a contact never pulls. ``sink`` is the speed at which a notch's floor falls away [m/s].
    """
    damping = loss_coefficient(force, loss, closing)
    return mean - give * closing - (give + damping) * sink, give + damping, force + damping * closing, damping, closing


@piece
def lasting_line(
    force: float, stiffness: float, closing: float, before: float, sink: float, payload: Payload
) -> tuple[float, float, float, float, float]:
    """Return the `line` of a contact of elastic ``force`` [N] and ``stiffness`` [N/m] in the middle of the step.

    ``closing`` is the speed of penetration expected, ``before`` that before the step [m/s].
    """
    give = 2.0 * DISPERSION * payload.step * stiffness
    return line(force, force + give * (closing - before), give, loss_law(force, stiffness, 1.0, payload), closing, sink)


@piece
def crosses(penetration: float, closing: float, before: float, step: float) -> bool:
    """Return whether a contact closes or opens within a step: see `crossing_line`."""
    begin = penetration - 0.5 * step * before
    return (begin > 0.0) != (begin + step * closing > 0.0)


@piece
def crossing_line(
    penetration: float, closing: float, before: float, sink: float, last: float, yielding: float, scale: float, payload: Payload
) -> tuple[float, float, float, float, float]:
    """Return the `line` of a contact that closes or opens within the step.

    ``penetration`` [m] is that in the middle of the step, as the speed of penetration ``before`` it would have it. ``closing`` is the
    speed expected if the force ``last`` [N] of the last step went on [m/s], ``yielding`` what a force takes off it [m/(N s)].
    """
    h, johnson = payload.step, payload.contact_law == JOHNSON
    begin = penetration - 0.5 * h * before
    force, _ = elastic(begin, scale, johnson, payload)
    energy, deep = potential(max(begin, 0.0), force, johnson, payload), max(begin, 0.0)
    mean = give = loss = change = 0.0
    # How far it gets hangs on the force, and this on how far: one step of Newton's method.
    for _ in range(2):
        closing += change
        way = h * closing
        by_way = 1.0 / way if abs(way) > LEAST_PENETRATION else 0.0
        after, _ = elastic(begin + way, scale, johnson, payload)
        deeper = max(begin + way, 0.0)
        over = (potential(deeper, after, johnson, payload) - energy) * by_way
        secant = max((after - force) * by_way, 0.0)
        bend = 2.0 * BEND * h * secant
        mean, give = max(over - bend * (closing - before), 0.0), h * (after - over) * by_way - bend
        loss = loss_law(mean, secant, (deeper - deep) * by_way, payload)
        change = yielding * (last - mean - loss * closing) / (1.0 + yielding * (give + loss))
    return line(mean, mean, give, loss, closing, sink)

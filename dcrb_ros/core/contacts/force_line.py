"""The normal force of a raceway contact over a step, as a straight line over its mean speed of approach.

A contact that is closed during the whole step takes the law's force in the middle of the step, and a mass of h^2 k/12 is added, which gives
leapfrog the right frequency to fourth order. The midpoint force misrepresents a step in which the contact opens or closes: a strike lasts
only a few steps, and the energy error reached 10 %, depending on when in the step the contact closed. Such a contact takes the mean force
over its way, the difference of the potential divided by the way (a discrete gradient; Gonzalez 1996, J. Nonlinear Sci. 6), with the same
correction of the mass. `docs/explanation/solver.md` derives both.
"""

from __future__ import annotations

from typing import Any

from dcrb_ros.core.arithmetic import LEAST_PENETRATION
from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import (
    film_damping,
    film_floor,
    film_lift,
    film_lift_energy,
    film_offset,
    film_reach,
    film_squeeze,
    normal_damping,
    normal_energy,
    normal_force,
    normal_range,
)
from dcrb_ros.core.laws.loss import loss_coefficient
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.payload import Payload

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""
MEAN_DISPERSION = 1.0 / 6.0
"""The mean force over a straight way corresponds to a mass of h^2 k/4; h^2 k/6 is taken off to leave h^2 k/12."""


LARGEST_CLOSING = 1.0
"""A contact may close within a step when its gap is less than this speed covers [m/s]; idle rollers are slower."""
SHORT_WAY = 0.1
"""Way over a step, relative to the gap, up to which the damping of a squeeze film at mid-step replaces its mean: within 0.2 %."""


@piece
def onset(law: Any, site: Site) -> float:
    """Return the gap at which the elastic contact closes [m]: on the film, if there is one, or where the law begins to act."""
    return normal_range(law) + film_offset(site.film)


@piece
def reach(law: Any, site: Site) -> float:
    """Return the gap up to which there is any force [m]."""
    return max(onset(law, site), film_reach(site.film))


@piece
def open_below(payload: Payload, site: Site) -> float:
    """Return the penetration of a contact with a smooth raceway below which the real one stays open over the step [m]."""
    return -LARGEST_CLOSING * payload.step - reach(payload.normal_law, site) - payload.profile_height


@piece
def elastic(law: Any, memory: Any, penetration: float, site: Site) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] at a penetration [m] below zero for a gap: of the elastic contact and of the film's lift."""
    least = -normal_range(law)
    deep = penetration + film_offset(site.film)
    force, stiffness = normal_force(law, memory, max(deep, LEAST_PENETRATION + least), site)
    lift, lift_stiffness = film_lift(site.film, -penetration)
    return (force if deep > least else 0.0) + lift, (stiffness if deep > least else 0.0) + lift_stiffness


@piece
def elastic_and_energy(law: Any, memory: Any, penetration: float, site: Site) -> tuple[float, float]:
    """Return force [N] and stored energy [J] at a penetration [m]; by a branch, for single contacts."""
    deep = penetration + film_offset(site.film)
    # The bounds keep both products from being fused into the sums: the compiler would choose one of two by the processor.
    lift, energy = max(film_lift(site.film, -penetration)[0], 0.0), max(film_lift_energy(site.film, -penetration), 0.0)
    if deep > -normal_range(law):
        force, _ = normal_force(law, memory, deep, site)
        return force + lift, normal_energy(law, memory, deep, force) + energy
    return lift, energy


@piece
def damping_of(payload: Payload, memory: Any, site: Site, begin: float, way: float, force: float, stiffness: float, share: float) -> float:
    """Return the damping [N s/m] of a contact that is closed for a ``share`` of the step [-], without its film; see `NormalLaw.damping`."""
    of_law = normal_damping(payload.normal_law, memory, site, begin, way, force, stiffness)
    return stiffness * payload.loss_time + payload.contact_damping * (share if force > 0.0 else 0.0) + of_law


@piece
def force_line(
    force: float, mean: float, slope: float, damping: float, closing: float, sink: float
) -> tuple[float, float, float, float, float]:
    """Return the line force_offset [N] + force_slope [N s/m] * approach, then expected force [N], its damping [N s/m] and ``closing``.

    ``mean`` [N] is the elastic force at the speed of penetration ``closing`` [m/s], ``slope`` its slope there, ``force`` [N] what
    the damping must not outweigh: a contact never pulls. ``sink`` is the speed at which the floor of a notch falls away [m/s].
    """
    damping = loss_coefficient(force, damping, closing)
    return mean - slope * closing - (slope + damping) * sink, slope + damping, force + damping * closing, damping, closing


@piece
def lasting_line(
    payload: Payload,
    memory: Any,
    site: Site,
    penetration: float,
    force: float,
    stiffness: float,
    closing: float,
    before: float,
    sink: float,
) -> tuple[float, float, float, float, float]:
    """Return the `force_line` of a contact of elastic ``force`` [N] and ``stiffness`` [N/m] at the ``penetration`` [m] in mid-step.

    ``closing`` is the speed of penetration expected if the force of the last step went on, ``before`` that before the step [m/s].
    """
    h = payload.step
    slope = 2.0 * DISPERSION * h * stiffness
    # The film's lift has stiffness, but no loss beside that of its squeezing.
    solid = stiffness - film_lift(site.film, -penetration)[1]
    begin = penetration - 0.5 * h * before
    damping = damping_of(payload, memory, site, begin, h * closing, force, solid, 1.0) + film_squeeze(site.film, -penetration, closing)
    return force_line(force, force + slope * (closing - before), slope, damping, closing, sink)


@piece
def crosses(law: Any, site: Site, penetration: float, closing: float, before: float, step: float) -> bool:
    """Return whether an elastic contact closes or opens within a step, or its film is squeezed by much: see `crossing_line`."""
    gap = onset(law, site)
    begin = penetration - 0.5 * step * before
    return (begin > -gap) != (begin + step * closing > -gap) or closes_quickly(site, -penetration, step * closing)


@piece
def closes_quickly(site: Site, gap: float, way: float) -> bool:
    """Return whether a gap [m] in mid-step closes by a ``way`` [m] over which the damping of a film changes by much."""
    floor = film_floor(site.film)
    return film_reach(site.film) > max(gap - 0.5 * way, 0.0) and way > SHORT_WAY * max(gap, floor) and gap + 0.5 * way > floor


@piece
def crossing_line(
    payload: Payload,
    memory: Any,
    site: Site,
    penetration: float,
    closing: float,
    before: float,
    sink: float,
    last: float,
    mobility: float,
) -> tuple[float, float, float, float, float]:
    """Return the `force_line` of a contact that closes or opens within the step.

    ``penetration`` [m] is that in the middle of the step, reached with the speed of penetration ``before`` [m/s]. ``closing`` is the mean
    speed if the force ``last`` [N] of the last step went on [m/s], ``mobility`` how the force changes it [m/(N s)].
    """
    h, law = payload.step, payload.normal_law
    gap = onset(law, site)
    begin = penetration - 0.5 * h * before
    force, energy = elastic_and_energy(law, memory, begin, site)
    deep = max(begin, -gap)
    mean = slope = damping = change = 0.0
    # The way depends on the force and the force on the way: one step of Newton's method.
    for _ in range(2):
        closing += change
        way = h * closing
        by_way = 1.0 / way if abs(way) > LEAST_PENETRATION else 0.0
        after, energy_after = elastic_and_energy(law, memory, begin + way, site)
        deeper = max(begin + way, -gap)
        over = (energy_after - energy) * by_way
        secant = max((after - force) * by_way, 0.0)
        correction = 2.0 * MEAN_DISPERSION * h * secant
        mean, slope = max(over - correction * (closing - before), 0.0), h * (after - over) * by_way - correction
        damping = damping_of(payload, memory, site, begin, way, mean, secant, (deeper - deep) * by_way)
        damping += film_damping(site.film, -begin, way)
        change = mobility * (last - mean - damping * closing) / (1.0 + mobility * (slope + damping))
    return force_line(mean, mean, slope, damping, closing, sink)

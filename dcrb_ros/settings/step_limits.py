"""The limits of the time step: whole steps in a sampling interval, the modes of vibration and the damping of a bearing under its load.

The range of the parameter is that of its field, `dcrb_ros.settings.simulation.SimulationParameters`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.core.laws.pereira import pereira_coefficients, pereira_stiffness
from dcrb_ros.faults.geometry import BrokenBar
from dcrb_ros.settings.groups import ParameterGroups
from dcrb_ros.settings.loaded_contacts import contact_stiffness, heaviest, load_and_weight
from dcrb_ros.settings.simulation import LONGEST_STEP, SHORTEST_STEP

LARGEST_PHASE = 1.8
"""Largest phase of the stiffest mode in a step [rad]: leapfrog is unstable from 2 on, and impacts stiffen the contacts."""
LARGEST_DAMPING = 0.8
"""Largest share of a body's momentum that contacts take up in a step [-]: the iteration of the bodies' velocities diverges from 1.0 on."""
LARGEST_ROLLER_DAMPING = 0.1
"""The same for viscous friction on a free roller [-]: simulations diverged from 0.2 on."""
LEAST_DRAG = 0.12
"""Smallest share of a roller's normal force that presses it against a bar: friction of 0.06 at both raceways [-]."""


def whole_steps(step: float, rate: int) -> Iterator[str]:
    """Yield a sentence if a sampling interval at ``rate`` [Hz] is not a whole number of steps [s], at least 2."""
    ratio = 1.0 / (step * rate)
    whole = max(2, round(ratio))
    if abs(ratio - whole) > 1e-6 * whole:
        fewest, most = max(2, math.ceil(1.0 / (LONGEST_STEP * rate))), math.floor(1.0 / (SHORTEST_STEP * rate))
        counts = sorted({min(max(n, fewest), most) for n in (math.floor(ratio), math.ceil(ratio))})
        nearest = ", ".join(f"{1.0 / (rate * n)!r}" for n in counts)
        yield (
            f"simulation.step = {step!r} s divides a sampling interval at sensor.sampling_rate = {rate} Hz into {ratio:.6g} steps; "
            f"this must be a whole number, at least 2: take {nearest} s"
        )


def step_limits(c: ParameterGroups) -> Iterator[str]:
    """Yield a sentence for each reason why the step is too long."""
    yield from _stability(c)
    yield from _damping(c)


def longest_step(c: ParameterGroups) -> float:
    """Return the longest step [s] that is stable with the stiffest mode and with the damping of the rings."""
    return min(_longest_stable_step(_stiffest_mode(c)[1]), _longest_damped_step(c))


def _stability(c: ParameterGroups) -> Iterator[str]:
    """Compare the step with the period of the stiffest mode under the largest forces that the load causes."""
    h, (name, natural) = c.simulation.step, _stiffest_mode(c)
    if h > _longest_stable_step(natural):
        yield (
            f"simulation.step = {h:g} s is too long for {name}, a mode at {natural / (2.0 * math.pi):.4g} Hz "
            f"under {load_and_weight(c):.4g} N: {_shorter(c, longest_step(c))}"
        )


def _stiffest_mode(c: ParameterGroups) -> tuple[str, float]:
    """Return the name and the angular frequency [rad/s] of the stiffest mode."""
    b = c.bearing
    stiffness = contact_stiffness(c, heaviest(c))
    together = 0.5 * stiffness * (1.0 + 0.25 * b.rollers_per_row) * b.rows
    inner, outer = b.inner_ring_mass + c.housing.axle_mass, b.outer_ring_mass + c.housing.box_mass
    modes = {
        "the rings against each other": together * (1.0 / inner + 1.0 / outer),
        "the outer ring in the housing": c.housing.stiffness / outer,
    }
    modes |= _modes_at_the_cage(c, stiffness)
    name = max(modes, key=modes.__getitem__)
    return name, math.sqrt(modes[name])


def _longest_stable_step(natural: float) -> float:
    """Return the longest step [s] for a mode at an angular frequency [rad/s]."""
    # The correction h^2 k/12 of the mass slows a mode: sin^2(phase/2) (1 + phase^2/12).
    return LARGEST_PHASE / natural / math.sqrt(1.0 - LARGEST_PHASE**2 / 12.0)


def _longest_damped_step(c: ParameterGroups) -> float:
    """Return the longest step [s] with which the contacts damp the rings."""
    b = c.bearing
    damping = c.contact.loss_time * contact_stiffness(c, heaviest(c)) + c.contact.damping
    inner, outer = b.inner_ring_mass + c.housing.axle_mass, b.outer_ring_mass + c.housing.box_mass
    rings = 0.5 * (1.0 + 0.25 * b.rollers_per_row) * b.rows * (1.0 / inner + 1.0 / outer)
    return LARGEST_DAMPING / (damping * rings) if damping else math.inf


def _damping(c: ParameterGroups) -> Iterator[str]:
    """Compare the damping of the contacts with the masses that it acts on in a step."""
    b, h, longest = c.bearing, c.simulation.step, _longest_damped_step(c)
    if h > longest:
        stiffness, constant = contact_stiffness(c, heaviest(c)), c.contact.damping
        lossy = c.contact.loss_time * stiffness
        largest = (lossy + constant) * longest / h
        words = f"contact.loss_time = {c.contact.loss_time:g} s", f"{max(0.0, largest - constant) / stiffness:.3g} s"
        if constant > lossy:
            words = f"contact.damping = {constant:g} N s/m", f"{max(0.0, largest - lossy):.3g} N s/m"
        yield (
            f"{words[0]} damps the rings too much for simulation.step = {h:g} s: at most {words[1]}, or a step of {_shorter(c, longest)}"
        )
    # The normal forces of all rollers add up to 4/pi of the load.
    viscous = h * c.friction.viscous
    excess = viscous * (1.0 / b.inner_ring_mass + 1.0 / b.outer_ring_mass) * 4.0 / math.pi * load_and_weight(c) / LARGEST_DAMPING
    if c.cage.joint == "pocket":
        excess = max(excess, viscous * heaviest(c) / b.roller_mass / LARGEST_ROLLER_DAMPING)
    if excess > 1.0:
        yield (
            f"friction.viscous = {c.friction.viscous:g} s/m damps slip too much for simulation.step = {h:g} s: at most "
            f"{c.friction.viscous / excess:.3g} s/m, or a step of at most {h / excess:.3g} s"
        )


def _largest_friction(c: ParameterGroups) -> float:
    """Return the largest friction coefficient between rollers and raceways [-]."""
    dry = c.lubrication.law == "dry"
    return float(c.friction.static_coefficient) if dry else max(c.lubrication.boundary_friction, c.lubrication.limiting_friction)


def _modes_at_the_cage(c: ParameterGroups, stiffness: float) -> dict[str, float]:
    """Return the squared angular frequencies [1/s^2] of cages, free rollers and bars; ``stiffness`` [N/m] is that of a raceway."""
    b = c.bearing
    any_broken = any(isinstance(damage, BrokenBar) for damage in c.faults.damage(b))
    if c.cage.joint == "revolute" and not any_broken:
        return {"a cage with its rollers": 2.0 * stiffness / (b.cage_mass + b.rollers_per_row * b.roller_mass)}
    drag = max(LEAST_DRAG, 2.0 * _largest_friction(c)) * heaviest(c)
    bar = pereira_stiffness(drag, *pereira_coefficients(c.cage.pocket_clearance, b.roller_length, b.effective_modulus))
    # Half a row presses against the cage at once: with more, simulations of light cages and small clearances diverged.
    pressing = 0.5 * b.rollers_per_row
    modes = {
        "a roller between the raceways": 2.0 * stiffness / b.roller_mass,
        "rollers against the bars of a cage": bar * (1.0 / b.roller_mass + pressing / b.cage_mass),
    }
    if any_broken:
        modes["two rollers beside a broken bar"] = (2.0 * stiffness + bar) / b.roller_mass
    return modes


def _shorter(c: ParameterGroups, longest: float) -> str:
    """Return the advice to take a step of at most ``longest`` [s]."""
    fitting = _fitting_step(c, longest)
    if fitting < SHORTEST_STEP:
        return f"even a step of {SHORTEST_STEP:g} s is too long; check masses in kg, stiffnesses and loads"
    return f"at most {longest:.3g} s, such as {fitting!r}"


def _fitting_step(c: ParameterGroups, longest: float) -> float:
    """Return the longest step up to ``longest`` [s] of which a sampling interval is a whole number."""
    return 1.0 / (c.sensor.sampling_rate * max(2, math.ceil(1.0 / (longest * c.sensor.sampling_rate))))

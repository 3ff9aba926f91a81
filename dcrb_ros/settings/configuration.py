"""The configuration of a simulation, and the checks of parameters that depend on each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pydantic import model_validator

from dcrb_ros.core.laws import NORMAL_LAWS
from dcrb_ros.core.laws.interface import Material, inner_site
from dcrb_ros.core.laws.pereira import pereira_coefficients, pereira_stiffness
from dcrb_ros.faults import Faults
from dcrb_ros.faults.geometry import BrokenBar
from dcrb_ros.faults.ground_truth import summary_of
from dcrb_ros.faults.raceway_defect import NOTCH
from dcrb_ros.measurement.stage import Parameters, Setup
from dcrb_ros.schema.fields import LENGTH_REMEDY, Group, quantity
from dcrb_ros.schema.parameter_field import Contradictions
from dcrb_ros.settings.contact import Contact, Friction
from dcrb_ros.settings.oil_limits import oil_limits
from dcrb_ros.settings.parameters import (
    SHORTEST_STEP,
    Bearing,
    Cage,
    Housing,
    Lubrication,
    Operating,
    Publishing,
    Recording,
    SimulationParameters,
    Surfaces,
    rpm,
)
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure
from dcrb_ros.settings.sensor_limits import block_limits, burst_limits, measurement_limits


class Configuration(Group):
    """All parameters of a simulation; they, the scenario and the simulated times of commands determine the samples."""

    bearing: Bearing = Bearing()
    housing: Housing = Housing()
    lubrication: Lubrication = Lubrication()
    surfaces: Surfaces = Surfaces()
    contact: Contact = Contact()
    friction: Friction = Friction()
    cage: Cage = Cage()
    operating: Operating = Operating()
    faults: Faults = Faults()
    simulation: SimulationParameters = SimulationParameters()
    structure: Structure = Structure()
    background: Background = Background()
    sensor: SensorParameters = SensorParameters()
    publishing: Publishing = Publishing()
    recording: Recording = Recording()
    time_scale: float = quantity(
        1.0,
        "-",
        "Requested ratio of simulated to wall time; 0 for as fast as possible",
        0.0,
        1000.0,
        remedy="give 0 for as fast as possible, 1 for real time",
        run_time=True,
    )

    @model_validator(mode="after")
    def _consistent(self) -> Configuration:
        if found := list(inconsistencies(self)):
            raise Contradictions(found)
        return self

    def described_faults(self) -> dict[str, dict[str, float]]:
        """Return the numbers of every fault of bearing and sensor by its name in the ground truth."""
        return self.faults.described() | self.sensor.described()

    @property
    def summary(self) -> str:
        """Speed, load and faults as text."""
        load = math.hypot(self.operating.load, self.operating.lateral_load)
        speed = f"{self.operating.speed:g} rad/s ({rpm(self.operating.speed):.4g} rpm)"
        return f"{speed}, {load / 1e3:g} kN, {summary_of(self.described_faults())}"

    def __repr__(self) -> str:
        return f"<Configuration: {self.summary}>"

    __str__ = __repr__

    @property
    def steps_per_sample(self) -> int:
        """Time steps in a sampling interval [-]."""
        return round(1.0 / (self.simulation.step * self.sensor.sampling_rate))

    @property
    def step_rate(self) -> int:
        """Time steps per simulated second [Hz]."""
        return self.steps_per_sample * self.sensor.sampling_rate

    @property
    def measurement(self) -> Setup:
        """Parameters, rate and seed from which the measurement chain is built."""
        return Setup(
            Parameters(self.structure, self.background, self.sensor),
            self.step_rate,
            self.simulation.seed,
            self.operating.wheel_diameter,
            self.operating.speed,
        )


def inconsistencies(c: Configuration) -> Iterator[str]:
    """Yield a sentence with values, range and remedy for each set of parameters that contradict each other."""
    geometry, rates, faults = list(_geometry(c)), list(_rates(c)), list(c.faults.problems(c.bearing))
    yield from geometry
    # What follows from impossible values would be impossible too.
    if not geometry:
        yield from _cage(c)
        yield from _guidance(c)
    yield from _housing(c)
    yield from rates
    yield from faults
    if not (geometry or faults):
        yield from _stability(c)
        yield from _damping(c)
        yield from oil_limits(c, material_of(c.bearing))
    yield from _splitting(c)
    if not rates:
        yield from measurement_limits(c.measurement)
    yield from block_limits(c.publishing, c.sensor.sampling_rate)
    yield from burst_limits(c.publishing, c.sensor.sampling_rate)
    yield from _surfaces(c)
    if c.friction.static_coefficient < c.friction.kinetic_coefficient:
        yield (
            f"friction.static_coefficient = {c.friction.static_coefficient:g} is below friction.kinetic_coefficient = "
            f"{c.friction.kinetic_coefficient:g}: make it at least as large"
        )


def _surfaces(c: Configuration) -> Iterator[str]:
    """Damage with heights of its own needs surfaces that have heights."""
    if c.surfaces.law == "profile":
        return
    for key, fault in c.faults.present():
        kind = getattr(fault, "kind", NOTCH)
        if kind != NOTCH:
            yield f"faults.{key}.kind = {kind} needs surfaces.law = profile, and it is {c.surfaces.law}: set both, or kind notch"


def _geometry(c: Configuration) -> Iterator[str]:
    b = c.bearing
    largest = 0.1 * b.roller_radius
    if not 0.0 < b.radial_gap <= largest:
        yield (
            f"bearing: the radial gap outer_raceway_radius - inner_raceway_radius - 2 roller_radius is {b.radial_gap:.4g} m, outside "
            f"0 .. {largest:.3g} m: check the three radii; lengths are in metres"
        )
    low, high = b.inner_raceway_radius + b.roller_radius, b.outer_raceway_radius - b.roller_radius
    if low <= high and not low <= b.pitch_radius <= high:
        yield f"bearing.pitch_radius = {b.pitch_radius:g} m is outside {low:g} .. {high:g} m, where a roller fits between the raceways"
    most = math.floor(math.pi / math.asin(min(1.0, b.roller_radius / b.pitch_radius)))
    if b.rollers_per_row > most:
        yield f"bearing.rollers_per_row = {b.rollers_per_row} do not fit around the pitch circle: use at most {most}, or smaller rollers"
    solid = 0.5 * b.roller_mass * b.roller_radius**2
    if not 0.25 * solid <= b.roller_inertia <= 4.0 * solid:
        yield (
            f"bearing.roller_inertia = {b.roller_inertia:g} kg m^2 is outside {0.25 * solid:.3g} .. {4.0 * solid:.3g} kg m^2: "
            f"a solid roller has mass * radius^2 / 2 = {solid:.3g}"
        )
    thin = b.cage_mass * b.pitch_radius**2
    if not 0.1 * thin <= b.cage_inertia <= 10.0 * thin:
        yield (
            f"bearing.cage_inertia = {b.cage_inertia:g} kg m^2 is outside {0.1 * thin:.3g} .. {10.0 * thin:.3g} kg m^2: "
            f"a thin cage has mass * pitch_radius^2 = {thin:.3g}"
        )


def _rates(c: Configuration) -> Iterator[str]:
    rate, step = c.sensor.sampling_rate, c.simulation.step
    ratio = 1.0 / (step * rate)
    whole = max(2, round(ratio))
    if abs(ratio - whole) > 1e-6 * whole:
        nearest = ", ".join(f"{1.0 / (rate * n)!r}" for n in sorted({max(2, math.floor(ratio)), max(2, math.ceil(ratio))}))
        yield (
            f"simulation.step = {step!r} s divides a sampling interval at sensor.sampling_rate = {rate} Hz into {ratio:.6g} steps; "
            f"this must be a whole number, at least 2: take {nearest} s"
        )
    if rate % c.publishing.preview_rate:
        yield (
            f"publishing.preview_rate = {c.publishing.preview_rate} Hz does not divide sensor.sampling_rate = {rate} Hz; "
            "take a divisor, such as 100 or 200"
        )


SMALLEST_FILE = 1_000_000
"""Smallest size at which a recording is split [bytes]: a few chunks."""


def _splitting(c: Configuration) -> Iterator[str]:
    size, duration = c.recording.split_size, c.recording.split_duration
    if 0 < size < SMALLEST_FILE:
        yield f"recording.split_size = {size} B is below {SMALLEST_FILE} B, a few chunks: increase it, or give 0 for a single file"
    if 0.0 < duration < 0.1:
        yield f"recording.split_duration = {duration:g} s is below 0.1 s, a few blocks: increase it, or give 0.0 for a single file"


def _cage(c: Configuration) -> Iterator[str]:
    b, cage = c.bearing, c.cage
    between = 2.0 * b.pitch_radius * math.sin(math.pi / b.rollers_per_row) - 2.0 * b.roller_radius
    if 2.0 * cage.pocket_clearance >= between:
        yield (
            f"cage.pocket_clearance = {cage.pocket_clearance:g} m on either side leaves no bar in the {between:.3g} m between two "
            f"rollers: it must be below {0.5 * between:.3g} m; {LENGTH_REMEDY}"
        )
    if cage.land_radius and not b.pitch_radius < cage.land_radius <= b.outer_raceway_radius + b.roller_radius:
        yield (
            f"cage.land_radius = {cage.land_radius:g} m is outside {b.pitch_radius:g} .. {b.outer_raceway_radius + b.roller_radius:g} m, "
            "from the pitch circle to the outer ring: give 0 for the default"
        )


def _guidance(c: Configuration) -> Iterator[str]:
    """Compare the clearances of the cage with its offset from the outer ring's centre in the loaded bearing."""
    b, cage = c.bearing, c.cage
    pinned = cage.joint == "revolute"
    pressed = 2.0 * heaviest(c) / contact_stiffness(c, heaviest(c))
    off = pressed + (b.outer_raceway_radius - b.roller_radius - b.pitch_radius if pinned else 0.5 * b.radial_gap)
    play = cage.land_clearance if pinned else cage.land_clearance + cage.pocket_clearance
    if off - pressed <= play < off and pressed > off - pressed:  # the clearances are sound, the load is not
        left = play - (off - pressed)
        yield (
            f"operating.load = {_load(c):.4g} N with the weight presses the rings {pressed:.3g} m towards each other, and the clearance of "
            f"the cage leaves {left:.3g} m: at most about {_heaviest_load(c, left):.3g} N"
        )
    elif play < off:
        name = "cage.land_clearance" if pinned else "cage.land_clearance + cage.pocket_clearance"
        yield (
            f"{name} = {play:.4g} m is below {off:.3g} m, the offset of the cage from the outer ring's centre in the loaded bearing: "
            "the cage would carry the load; make it larger or the radial gap smaller"
        )


def _heaviest_load(c: Configuration, most: float) -> float:
    """Return the load [N] that presses the rings ``most`` [m] towards each other, to a few per cent and rather too low."""
    force = heaviest(c)
    while 2.0 * force / contact_stiffness(c, force) > most:
        force *= 0.98
    return _load(c) * force / heaviest(c)


def heaviest(c: Configuration) -> float:
    """Return the largest normal force of a roller [N]: five times the mean of a row, as without a radial gap (Stribeck)."""
    return max(1.0, 5.0 * _load(c) / (c.bearing.rows * c.bearing.rollers_per_row))


def _load(c: Configuration) -> float:
    """Return the sum of load and weight on the inner ring [N]."""
    return math.hypot(c.operating.load, c.operating.lateral_load) + c.bearing.inner_ring_mass * c.operating.gravity


LARGEST_PHASE = 1.8
"""Largest phase of the stiffest mode in a step [rad]: leapfrog is unstable from 2 on, and impacts stiffen the contacts."""


def _stability(c: Configuration) -> Iterator[str]:
    """Compare the step with the period of the stiffest mode under the largest forces that the load causes."""
    b, h = c.bearing, c.simulation.step
    stiffness = contact_stiffness(c, heaviest(c))
    together = 0.5 * stiffness * (1.0 + 0.25 * b.rollers_per_row) * b.rows
    inner, outer = b.inner_ring_mass + c.housing.axle_mass, b.outer_ring_mass + c.housing.box_mass
    modes = {
        "the rings against each other": together * (1.0 / inner + 1.0 / outer),
        "the outer ring in the housing": c.housing.stiffness / outer,
    }
    modes |= _modes_at_the_cage(c, stiffness)
    # The correction h^2 k/12 of the mass slows a mode: sin^2(phase/2) (1 + phase^2/12).
    name = max(modes, key=modes.__getitem__)
    natural = math.sqrt(modes[name])
    longest = LARGEST_PHASE / natural / math.sqrt(1.0 - LARGEST_PHASE**2 / 12.0)
    if h > longest:
        yield (
            f"simulation.step = {h:g} s is too long for {name}, a mode at {natural / (2.0 * math.pi):.4g} Hz "
            f"under {_load(c):.4g} N: {_shorter(c, min(longest, _longest_damped_step(c)))}"
        )


def _housing(c: Configuration) -> Iterator[str]:
    """Compare the housing's deflection with the roller radius, beyond which the outer ring has left its seat."""
    force = _load(c) + c.bearing.outer_ring_mass * c.operating.gravity
    softest = 2.0 * force / c.bearing.roller_radius
    if c.housing.stiffness < softest:
        yield (
            f"housing.stiffness = {c.housing.stiffness:g} N/m gives way by {force / c.housing.stiffness:.3g} m under {force:.4g} N: "
            f"at least {softest:.3g} N/m keeps the outer ring within half a roller radius; give N/m, not N/um"
        )


LARGEST_DAMPING = 0.8
"""Largest share of a body's momentum that contacts take up in a step [-]: the iteration of the bodies' velocities diverges from 1.0 on."""
LARGEST_ROLLER_DAMPING = 0.1
"""The same for viscous friction on a free roller [-]: simulations diverged from 0.2 on."""


def _longest_damped_step(c: Configuration) -> float:
    """Return the longest step [s] with which the contacts damp the rings."""
    b = c.bearing
    damping = c.contact.loss_time * contact_stiffness(c, heaviest(c)) + c.contact.damping
    inner, outer = b.inner_ring_mass + c.housing.axle_mass, b.outer_ring_mass + c.housing.box_mass
    rings = 0.5 * (1.0 + 0.25 * b.rollers_per_row) * b.rows * (1.0 / inner + 1.0 / outer)
    return LARGEST_DAMPING / (damping * rings) if damping else math.inf


def _damping(c: Configuration) -> Iterator[str]:
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
    excess = viscous * (1.0 / b.inner_ring_mass + 1.0 / b.outer_ring_mass) * 4.0 / math.pi * _load(c) / LARGEST_DAMPING
    if c.cage.joint == "pocket":
        excess = max(excess, viscous * heaviest(c) / b.roller_mass / LARGEST_ROLLER_DAMPING)
    if excess > 1.0:
        yield (
            f"friction.viscous = {c.friction.viscous:g} s/m damps slip too much for simulation.step = {h:g} s: at most "
            f"{c.friction.viscous / excess:.3g} s/m, or a step of at most {h / excess:.3g} s"
        )


LEAST_DRAG = 0.12
"""Smallest share of a roller's normal force that presses it against a bar: friction of 0.06 at both raceways [-]."""


def _largest_friction(c: Configuration) -> float:
    """Return the largest friction coefficient between rollers and raceways [-]."""
    dry = c.lubrication.law == "dry"
    return float(c.friction.static_coefficient) if dry else max(c.lubrication.boundary_friction, c.lubrication.limiting_friction)


def _modes_at_the_cage(c: Configuration, stiffness: float) -> dict[str, float]:
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


def _shorter(c: Configuration, longest: float) -> str:
    """Return the advice to take a step of at most ``longest`` [s]."""
    fitting = _fitting_step(c, longest)
    if fitting < SHORTEST_STEP:
        return f"even a step of {SHORTEST_STEP:g} s is too long; check masses in kg, stiffnesses and loads"
    return f"at most {longest:.3g} s, such as {fitting!r}"


def _fitting_step(c: Configuration, longest: float) -> float:
    """Return the longest step up to ``longest`` [s] of which a sampling interval is a whole number."""
    return 1.0 / (c.sensor.sampling_rate * max(2, math.ceil(1.0 / (longest * c.sensor.sampling_rate))))


def material_of(bearing: Bearing) -> Material:
    """Return what the constants of contact laws may depend on."""
    return Material(**{name: getattr(bearing, name) for name in Material._fields})


def contact_stiffness(c: Configuration, force: float) -> float:
    """Return the stiffness [N/m] of a roller's contact with the inner raceway under a normal force [N]."""
    law = NORMAL_LAWS[c.contact.law]
    return float(law.stiffness(law.build(dict(c.contact), material_of(c.bearing)), force, inner_site(material_of(c.bearing))))

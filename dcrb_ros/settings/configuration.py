"""The whole configuration of a bench: read, checked once, explained when refused."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pydantic import model_validator

from dcrb_ros.core.laws import NORMAL_LAWS
from dcrb_ros.core.laws.interface import Material, inner_site
from dcrb_ros.core.laws.pereira import pereira_coefficients, pereira_stiffness
from dcrb_ros.faults.defects import Faults, RacewayDefect, RollerDefect
from dcrb_ros.schema.fields import LENGTH_REMEDY, Group, quantity
from dcrb_ros.settings.contact import Contact, Friction
from dcrb_ros.settings.parameters import (
    SHORTEST_STEP,
    Bearing,
    Cage,
    Housing,
    Operating,
    Publishing,
    Recording,
    SimulationParameters,
)
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure
from dcrb_ros.settings.sensor_limits import endless_blocks, filters_beyond, impossible_bursts, impossible_modes


class Configuration(Group):
    """Everything a bench depends on; the samples follow from this and the simulated times of commands."""

    bearing: Bearing = Bearing()
    housing: Housing = Housing()
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
    time_scale: float = quantity(1.0, "-", "Simulated over wall time asked for; 0 for as fast as possible", 0.0, 1000.0, run_time=True)

    @model_validator(mode="after")
    def _consistent(self) -> Configuration:
        for fault in inconsistencies(self):
            raise ValueError(fault)
        return self

    def described_faults(self) -> dict[str, dict[str, float]]:
        """Return the fields of every fault of bearing and sensor by its name in the ground truth."""
        return self.faults.described() | self.sensor.described()

    @property
    def steps_per_sample(self) -> int:
        """Time steps between two samples [-]."""
        return round(1.0 / (self.simulation.step * self.sensor.sampling_rate))

    @property
    def step_rate(self) -> int:
        """Time steps in a simulated second [Hz]."""
        return self.steps_per_sample * self.sensor.sampling_rate


def inconsistencies(c: Configuration) -> Iterator[str]:
    """Yield a sentence for everything that cannot be true together: what, the range, the remedy."""
    yield from _geometry(c)
    yield from _cage(c)
    yield from _guidance(c)
    yield from _rates(c)
    yield from _notches(c)
    yield from _bars(c)
    yield from _stability(c)
    yield from _splitting(c)
    yield from filters_beyond(c.sensor, c.background, c.step_rate)
    yield from impossible_modes(c.structure)
    yield from endless_blocks(c.publishing, c.sensor.sampling_rate)
    yield from impossible_bursts(c.publishing, c.sensor.sampling_rate)
    if c.friction.static_coefficient < c.friction.kinetic_coefficient:
        yield (
            f"friction.static_coefficient = {c.friction.static_coefficient:g} is below friction.kinetic_coefficient = "
            f"{c.friction.kinetic_coefficient:g}: make it at least as large"
        )


def _geometry(c: Configuration) -> Iterator[str]:
    b = c.bearing
    largest = 0.1 * b.roller_radius
    if not 0.0 < b.radial_gap <= largest:
        yield (
            f"bearing: the radial gap outer_raceway_radius - inner_raceway_radius - 2 roller_radius is {b.radial_gap:.4g} m, outside "
            f"0 .. {largest:.3g} m: check the three radii, lengths are in metres"
        )
    low, high = b.inner_raceway_radius + b.roller_radius, b.outer_raceway_radius - b.roller_radius
    if not low <= b.pitch_radius <= high:
        yield f"bearing.pitch_radius = {b.pitch_radius:g} m is outside {low:g} .. {high:g} m, where a roller fits between the raceways"
    most = math.floor(math.pi / math.asin(min(1.0, b.roller_radius / b.pitch_radius)))
    if b.rollers_per_row > most:
        yield f"bearing.rollers_per_row = {b.rollers_per_row} do not fit round the pitch circle: {most} rollers at most, or smaller ones"
    solid = 0.5 * b.roller_mass * b.roller_radius**2
    if not 0.25 * solid <= b.roller_inertia <= 4.0 * solid:
        yield (
            f"bearing.roller_inertia = {b.roller_inertia:g} kg m^2 is outside {0.25 * solid:.3g} .. {4.0 * solid:.3g} kg m^2: "
            f"a solid roller has mass * radius^2 / 2 = {solid:.3g}"
        )


def _rates(c: Configuration) -> Iterator[str]:
    rate, step = c.sensor.sampling_rate, c.simulation.step
    ratio = 1.0 / (step * rate)
    whole = max(2, round(ratio))
    if abs(ratio - whole) > 1e-6 * whole:
        near = ", ".join(f"{1.0 / (rate * n)!r}" for n in sorted({max(2, math.floor(ratio)), max(2, math.ceil(ratio))}))
        yield (
            f"simulation.step = {step!r} s makes {ratio:.6g} steps of a sample at sensor.sampling_rate = {rate} Hz; "
            f"it must make a whole number from 2 up: take {near} s"
        )
    if rate % c.publishing.preview_rate:
        yield (
            f"publishing.preview_rate = {c.publishing.preview_rate} Hz does not divide sensor.sampling_rate = {rate} Hz; "
            "take a divisor, such as 100 or 200"
        )


SMALLEST_FILE = 1_000_000
"""Smallest file of a recording in several files [bytes]: a few chunks."""


def _splitting(c: Configuration) -> Iterator[str]:
    size, duration = c.recording.split_size, c.recording.split_duration
    if 0 < size < SMALLEST_FILE:
        yield f"recording.split_size = {size} B is below {SMALLEST_FILE} B, a few chunks: give 0 for a single file or more"
    if 0.0 < duration < 0.1:
        yield f"recording.split_duration = {duration:g} s is below 0.1 s, a few blocks: give 0.0 for a single file or more"


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
    """Compare the cage's clearances with how far the loaded ring carries it off the outer ring's centre."""
    b, cage = c.bearing, c.cage
    pinned = cage.joint == "revolute"
    pressed = 2.0 * heaviest(c) / contact_stiffness(c, heaviest(c))
    off = pressed + (b.outer_raceway_radius - b.roller_radius - b.pitch_radius if pinned else 0.5 * b.radial_gap)
    play = cage.land_clearance if pinned else cage.land_clearance + cage.pocket_clearance
    if play < off:
        name = "cage.land_clearance" if pinned else "cage.land_clearance + cage.pocket_clearance"
        yield (
            f"{name} = {play:.4g} m is below the {off:.3g} m by which a loaded bearing carries its cage off the outer ring's centre: "
            "the cage would bear the load; make it larger or the radial gap smaller"
        )


def heaviest(c: Configuration) -> float:
    """Return the force on the roller under the load, without a gap five times the mean of a row (Stribeck) [N]."""
    return max(1.0, 5.0 * _load(c) / (c.bearing.rows * c.bearing.rollers_per_row))


def _load(c: Configuration) -> float:
    """Return load and weight on the inner ring [N]."""
    return math.hypot(c.operating.load, c.operating.lateral_load) + c.bearing.inner_ring_mass * c.operating.gravity


def _notches(c: Configuration) -> Iterator[str]:
    b = c.bearing
    for ring, raceway in (("inner", b.inner_raceway_radius), ("outer", b.outer_raceway_radius)):
        found = list(c.faults.raceway_defects(ring))
        for i, (name, notch) in enumerate(found):
            yield from _width(name, notch.width, 2.0 * math.pi * raceway / b.rollers_per_row, "pitch")
            if notch.row > b.rows:
                yield f"faults.{name}.row = {notch.row} is outside 0 .. {b.rows}: the bearing has {b.rows} row(s), 0 means all"
            for other_name, other in found[:i]:
                shared = not (notch.row and other.row and notch.row != other.row)
                yield from _overlap(name, notch, other_name, other, raceway) if shared else ()
    rollers = list(c.faults.roller_defects())
    for i, (name, defect) in enumerate(rollers):
        yield from _width(name, defect.width, b.roller_radius, "roller's radius")
        if defect.row > b.rows or defect.roller > b.rollers_per_row:
            yield (
                f"faults.{name}: there is no roller {defect.roller} in row {defect.row}; the bearing has {b.rows} row(s) of "
                f"{b.rollers_per_row} rollers"
            )
        for other_name, second in rollers[:i]:
            if (defect.row, defect.roller) == (second.row, second.roller):
                yield from _overlap(name, defect, other_name, second, b.roller_radius)


def _width(name: str, width: float, limit: float, what: str) -> Iterator[str]:
    if width >= limit:
        yield f"faults.{name}.width = {width:g} m is not below the {what} of {limit:.4g} m: {LENGTH_REMEDY}"


def _overlap(
    name: str, notch: RacewayDefect | RollerDefect, other_name: str, other: RacewayDefect | RollerDefect, radius: float
) -> Iterator[str]:
    apart = abs(math.remainder(notch.azimuth - other.azimuth, 2.0 * math.pi)) * radius
    if apart < 0.5 * (notch.width + other.width):
        yield (
            f"faults.{name} overlaps faults.{other_name}: their middles are {apart:.4g} m apart; "
            "move an azimuth or join them into one defect"
        )


def _bars(c: Configuration) -> Iterator[str]:
    b = c.bearing
    try:
        bars = c.faults.bars()
    except ValueError as error:
        yield str(error)
        return
    for row, bar in bars:
        if not (1 <= row <= b.rows and 1 <= bar <= b.rollers_per_row):
            yield (
                f"faults.broken_bars: row{row}/bar{bar} is outside row1/bar1 .. row{b.rows}/bar{b.rollers_per_row}: "
                "bar k stands between rollers k and k + 1"
            )
    if len(set(bars)) < len(bars):
        yield f"faults.broken_bars = '{c.faults.broken_bars}' names a bar twice: name each once"
    for row in range(1, b.rows + 1):
        if sum(at == row for at, _ in set(bars)) > b.rollers_per_row - 2:
            yield f"faults.broken_bars leaves fewer than two bars in row {row}: a cage needs two to drive its rollers"


LARGEST_PHASE = 1.8
"""Largest phase of the stiffest mode in a step [rad]; from 2 on leapfrog grows without bound, and impacts stiffen the contacts."""


def _stability(c: Configuration) -> Iterator[str]:
    """Compare the step with the stiffest mode, at the largest forces that the load can bring about."""
    b, h = c.bearing, c.simulation.step
    stiffness = contact_stiffness(c, heaviest(c))
    together = 0.5 * stiffness * (1.0 + 0.25 * b.rollers_per_row) * b.rows
    modes = {
        "the rings against each other": together * (1.0 / b.inner_ring_mass + 1.0 / b.outer_ring_mass),
        "the outer ring in the housing": c.housing.stiffness / b.outer_ring_mass,
    }
    modes |= _modes_at_the_cage(c, stiffness)
    # The correction h^2 k/12 of the mass slows a mode: sin^2(phase/2) (1 + phase^2/12).
    name = max(modes, key=modes.__getitem__)
    natural = math.sqrt(modes[name])
    longest = LARGEST_PHASE / natural / math.sqrt(1.0 - LARGEST_PHASE**2 / 12.0)
    if h > longest:
        yield (
            f"simulation.step = {h:g} s is too long for {name}, a mode at {natural / (2.0 * math.pi):.4g} Hz "
            f"under {_load(c):.4g} N: {_shorter(c, longest)}"
        )


LEAST_DRAG = 0.12
"""Least share of a roller's normal force that presses it against a bar: friction of 0.06 at both raceways [-]."""


def _modes_at_the_cage(c: Configuration, stiffness: float) -> dict[str, float]:
    """Return the squared frequencies [1/s^2] of cages, free rollers and bars, the raceways being of ``stiffness`` [N/m]."""
    b = c.bearing
    if c.cage.joint == "revolute" and not c.faults.broken_bars:
        return {"a cage with its rollers": 2.0 * stiffness / (b.cage_mass + b.rollers_per_row * b.roller_mass)}
    drag = max(LEAST_DRAG, 2.0 * c.friction.static_coefficient) * heaviest(c)
    bar = pereira_stiffness(drag, *pereira_coefficients(c.cage.pocket_clearance, b.roller_length, b.effective_modulus))
    # Half a row pressing its cage at once: light cages and tight pockets failed from about there on.
    pressing = 0.5 * b.rollers_per_row
    modes = {
        "a roller between the raceways": 2.0 * stiffness / b.roller_mass,
        "rollers against the bars of a cage": bar * (1.0 / b.roller_mass + pressing / b.cage_mass),
    }
    if c.faults.broken_bars:
        modes["two rollers beside a broken bar"] = (2.0 * stiffness + bar) / b.roller_mass
    return modes


def _shorter(c: Configuration, longest: float) -> str:
    """Return the advice to take a step of ``longest`` [s] at most."""
    fitting = _fitting_step(c, longest)
    if fitting < SHORTEST_STEP:
        return f"no step from {SHORTEST_STEP:g} s up follows it; check masses in kg, stiffnesses and loads"
    return f"at most {longest:.3g} s, such as {fitting!r}"


def _fitting_step(c: Configuration, longest: float) -> float:
    """Return the longest step up to ``longest`` [s] that makes a whole number of a sample."""
    return 1.0 / (c.sensor.sampling_rate * max(2, math.ceil(1.0 / (longest * c.sensor.sampling_rate))))


def material_of(bearing: Bearing) -> Material:
    """Return what the constants of contact laws may depend on."""
    return Material(**{name: getattr(bearing, name) for name in Material._fields})


def contact_stiffness(c: Configuration, force: float) -> float:
    """Return the stiffness [N/m] of a roller's contact with the inner raceway under a normal force [N]."""
    law = NORMAL_LAWS[c.contact.law]
    return float(law.stiffness(law.build(dict(c.contact), material_of(c.bearing)), force, inner_site(material_of(c.bearing))))

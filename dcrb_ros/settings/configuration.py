"""The configuration of a simulation, and the checks of parameters that depend on each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pydantic import model_validator

from dcrb_ros.faults.ground_truth import summary_of
from dcrb_ros.faults.raceway_defect import NOTCH
from dcrb_ros.measurement.stage import Parameters, Setup
from dcrb_ros.schema.fields import LENGTH_REMEDY
from dcrb_ros.schema.parameter_field import Contradictions
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.groups import ParameterGroups
from dcrb_ros.settings.impact_limits import impact_limits
from dcrb_ros.settings.loaded_contacts import contact_stiffness, heaviest, load_and_weight, material_of
from dcrb_ros.settings.measured_rate import preview_at
from dcrb_ros.settings.oil_limits import oil_limits
from dcrb_ros.settings.parameters import rpm
from dcrb_ros.settings.sensor_limits import block_limits, burst_limits, measurement_limits, tacho_limits
from dcrb_ros.settings.step_limits import step_limits, whole_steps
from dcrb_ros.settings.thermal import thermal_limits


class Configuration(ParameterGroups):
    """All parameters of a simulation; they, the scenario and the simulated times of commands determine the samples."""

    @model_validator(mode="after")
    def _consistent(self) -> Configuration:
        if sentences := list(inconsistencies(self)):
            raise Contradictions(sentences)
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
    geometry, faults = list(_geometry(c)), list(c.faults.problems(c.bearing))
    rates = [*whole_steps(c.simulation.step, c.sensor.sampling_rate), *_preview(c)]
    yield from geometry
    # What follows from impossible values would be impossible too.
    if not geometry:
        yield from _cage(c)
        yield from _guidance(c)
    yield from _housing(c)
    yield from rates
    yield from faults
    if not (geometry or faults):
        yield from step_limits(c)
        yield from oil_limits(c, material_of(c.bearing))
    yield from thermal_limits(c.thermal, c.faults.condition, c.lubrication.law, c.cage.joint)
    yield from _splitting(c)
    if not rates:
        yield from measurement_limits(c.measurement)
    yield from block_limits(c.publishing, c.sensor.sampling_rate)
    yield from burst_limits(c.publishing, c.sensor.sampling_rate)
    yield from tacho_limits(c.tacho, c.operating.speed, c.sensor.sampling_rate)
    yield from _surfaces(c)
    yield from impact_limits(c)
    if c.friction.static_coefficient < c.friction.kinetic_coefficient:
        yield (
            f"friction.static_coefficient = {c.friction.static_coefficient:g} is below friction.kinetic_coefficient = "
            f"{c.friction.kinetic_coefficient:g}: make it at least as large"
        )


def _surfaces(c: ParameterGroups) -> Iterator[str]:
    """Damage with heights of its own needs surfaces that have heights."""
    if c.surfaces.law == "profile":
        return
    for key, fault in c.faults.present():
        kind = getattr(fault, "kind", NOTCH)
        if kind != NOTCH:
            yield f"faults.{key}.kind = {kind} needs surfaces.law = profile, and it is {c.surfaces.law}: set both, or kind notch"


def _geometry(c: ParameterGroups) -> Iterator[str]:
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
    most = math.floor(math.pi / math.asin(min(1.0, b.own_roller_radius / b.pitch_radius)))
    if b.rollers_per_row > most:
        yield f"bearing.rollers_per_row = {b.rollers_per_row} do not fit around the pitch circle: use at most {most}, or smaller rollers"
    solid = 0.5 * b.roller_mass * b.own_roller_radius**2
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


def _preview(c: ParameterGroups) -> Iterator[str]:
    rate = c.sensor.sampling_rate
    if rate % c.publishing.preview_rate == 0:
        return
    try:
        yield (
            f"publishing.preview_rate = {c.publishing.preview_rate} Hz does not divide sensor.sampling_rate = {rate} Hz; "
            f"take a divisor, such as {preview_at(rate)}"
        )
    except Refusal as refusal:
        yield f"sensor.{refusal}"


SMALLEST_FILE = 1_000_000
"""Smallest size at which a recording is split [bytes]: a few chunks."""


def _splitting(c: ParameterGroups) -> Iterator[str]:
    size, duration = c.recording.split_size, c.recording.split_duration
    if 0 < size < SMALLEST_FILE:
        yield f"recording.split_size = {size} B is below {SMALLEST_FILE} B, a few chunks: increase it, or give 0 for a single file"
    if 0.0 < duration < 0.1:
        yield f"recording.split_duration = {duration:g} s is below 0.1 s, a few blocks: increase it, or give 0.0 for a single file"


def _cage(c: ParameterGroups) -> Iterator[str]:
    b, cage = c.bearing, c.cage
    between = 2.0 * b.pitch_radius * math.sin(math.pi / b.rollers_per_row) - 2.0 * b.own_roller_radius
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


def _guidance(c: ParameterGroups) -> Iterator[str]:
    """Compare the clearances of the cage with its offset from the outer ring's centre in the loaded bearing."""
    b, cage = c.bearing, c.cage
    pinned = cage.joint == "revolute"
    pressed = 2.0 * heaviest(c) / contact_stiffness(c, heaviest(c))
    off = pressed + (b.outer_raceway_radius - b.roller_radius - b.pitch_radius if pinned else 0.5 * b.radial_gap)
    play = cage.land_clearance if pinned else cage.land_clearance + cage.pocket_clearance
    if off - pressed <= play < off and pressed > off - pressed:  # the clearances are sound, the load is not
        left = play - (off - pressed)
        yield (
            f"operating.load = {load_and_weight(c):.4g} N with the weight presses the rings {pressed:.3g} m towards each other, and the "
            f"clearance of the cage leaves {left:.3g} m: at most about {_heaviest_load(c, left):.3g} N"
        )
    elif play < off:
        name = "cage.land_clearance" if pinned else "cage.land_clearance + cage.pocket_clearance"
        yield (
            f"{name} = {play:.4g} m is below {off:.3g} m, the offset of the cage from the outer ring's centre in the loaded bearing: "
            "the cage would carry the load; make it larger or the radial gap smaller"
        )


def _heaviest_load(c: ParameterGroups, most: float) -> float:
    """Return the load [N] that presses the rings ``most`` [m] towards each other, to a few per cent and rather too low."""
    force = heaviest(c)
    while 2.0 * force / contact_stiffness(c, force) > most:
        force *= 0.98
    return load_and_weight(c) * force / heaviest(c)


def _housing(c: ParameterGroups) -> Iterator[str]:
    """Compare the housing's deflection with the roller radius, beyond which the outer ring has left its seat.

    A primary suspension has the preload that keeps it there.
    """
    if c.housing.suspension_damping > 0.0 and c.housing.suspension_stiffness == 0.0:
        yield (
            f"housing.suspension_damping = {c.housing.suspension_damping:g} N s/m damps a primary suspension, and there is none: give "
            "housing.suspension_stiffness in N/m, or remove it"
        )
    force = load_and_weight(c) + c.bearing.outer_ring_mass * c.operating.gravity
    softest = 2.0 * force / c.bearing.roller_radius
    if c.housing.suspension_stiffness == 0.0 and c.housing.stiffness < softest:
        yield (
            f"housing.stiffness = {c.housing.stiffness:g} N/m gives way by {force / c.housing.stiffness:.3g} m under {force:.4g} N: "
            f"at least {softest:.3g} N/m keeps the outer ring within half a roller radius; give N/m, not N/um"
        )

"""The whole configuration of a bench: read, checked once, explained when refused."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pydantic import model_validator

from dcrb_ros.faults import Faults
from dcrb_ros.parameters import (
    LENGTH_REMEDY,
    Bearing,
    Cage,
    Contact,
    Friction,
    Group,
    Housing,
    Operating,
    Publishing,
    Recording,
    SensorParameters,
    SimulationParameters,
    quantity,
)


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
    sensor: SensorParameters = SensorParameters()
    publishing: Publishing = Publishing()
    recording: Recording = Recording()
    time_scale: float = quantity(1.0, "-", "Simulated over wall time asked for; 0 for as fast as possible", 0.0, 1000.0)

    @model_validator(mode="after")
    def _consistent(self) -> Configuration:
        for fault in inconsistencies(self):
            raise ValueError(fault)
        return self

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
    yield from _rates(c)
    yield from _defects(c)
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


def _defects(c: Configuration) -> Iterator[str]:
    b = c.bearing
    found = list(c.faults.present())
    for name, defect in found:
        raceway = b.inner_raceway_radius if name.startswith("inner") else b.outer_raceway_radius
        pitch = 2.0 * math.pi * raceway / b.rollers_per_row
        if defect.width >= pitch:
            yield f"faults.{name}.width = {defect.width:g} m is not below the pitch of {pitch:.4g} m: {LENGTH_REMEDY}"
        if defect.row > b.rows:
            yield f"faults.{name}.row = {defect.row} is outside 0 .. {b.rows}: the bearing has {b.rows} row(s), 0 means all"
    for i, (name, defect) in enumerate(found):
        for other_name, other in found[:i]:
            if other_name[:5] != name[:5] or (defect.row and other.row and defect.row != other.row):
                continue
            raceway = b.inner_raceway_radius if name.startswith("inner") else b.outer_raceway_radius
            apart = abs(math.remainder(defect.azimuth - other.azimuth, 2.0 * math.pi)) * raceway
            if apart < 0.5 * (defect.width + other.width):
                yield (
                    f"faults.{name} overlaps faults.{other_name}: their middles are {apart:.4g} m apart; "
                    "move an azimuth or join them into one defect"
                )

"""The parameters of a vehicle, group by group, as its file has them.

The vehicle's axes are those of REP 103: x forward, y to the left, z up. Bearings are seen from the left, so that their X is -x and their
Y is z.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from pydantic import Field, model_validator

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.schema.fields import Group, choice, length, quantity
from dcrb_ros.schema.parameter_field import Contradictions
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.vehicle_description import AxleDescription, BoxDescription, VehicleDescription

GRAVITY = 9.81
"""[m/s^2]"""
SIDES = ("left", "right")
WHEEL_DISTANCE, JOURNAL_DISTANCE = 1.5, 2.0
"""Distance of the contacts and of the boxes of a wheelset [m]."""
SHORTEST_RAIL = 1.0
"""Shortest distance of the joints of a rail [m]; the time of a run grows with their number."""


class Journey(Group):
    """How the vehicle runs: the section ``vehicle``."""

    bench: str = choice("healthy", "Configuration of every box that names no other one")
    seed: int = quantity(1, "-", "Seed; each box has a hash of it and of its name", 0, 2**31 - 1)
    speed_kmh: float = quantity(120.0, "km/h", "Speed at the start; a vehicle always moves", 5.0, 300.0)
    ramp: float = quantity(0.5, "m/s^2", "Rate at which a commanded speed is approached", 0.01, 3.0)
    curvature: float = quantity(0.0, "1/m", "Curvature of the track, positive to the left", -0.01, 0.01)
    cant: float = length(0.0, "Height of the outer rail over the inner one; it acts in a curve only", 0.0, 0.18)
    brake: float = quantity(0.0, "m/s^2", "Deceleration by the brakes that loads the boxes along the track", 0.0, 1.5)
    wind: float = quantity(0.0, "N", "Force of the wind on the side of the vehicle, positive to the left", -1e5, 1e5)
    on_failure: Literal["stop", "continue"] = Field(
        "stop",
        description="What happens when the model of a box fails: the run ends, or that box is silent",
        json_schema_extra={"unit": "-", "symbol": "", "remedy": "", "run_time": False},
    )


class Body(Group):
    """The body of the vehicle, which acts by its weight only."""

    mass: float = quantity(32000.0, "kg", "Mass of the body", 1e3, 1e5)
    height: float = length(1.3, "Height of its centre of mass over the springs", 0.0, 3.0)
    wind_height: float = length(1.5, "Height at which the wind acts, over the springs", 0.0, 3.0)
    bogies: float = length(19.0, "Distance of the bogies", 5.0, 25.0)


class Frame(Group):
    """The frame of the bogie."""

    mass: float = quantity(2615.0, "kg", "Mass", 500.0, 1e4)
    height: float = length(0.2, "Height of its centre of mass over the springs", 0.0, 1.0)
    roll: float = quantity(1722.0, "kg m^2", "Moment of inertia about x", 100.0, 1e4)
    pitch: float = quantity(1476.0, "kg m^2", "Moment of inertia about y", 100.0, 1e4)


class Suspension(Group):
    """Springs and dampers: the primary ones of a box, the secondary ones of a side."""

    primary: float = quantity(1.2e6, "N/m", "Stiffness of the primary suspension of a box", 1e5, 1e7)
    primary_damping: float = quantity(4.0e3, "N s/m", "Damping of the primary suspension of a box", 1e2, 1e5)
    secondary: float = quantity(0.43e6, "N/m", "Stiffness of the secondary suspension of a side", 1e5, 1e7)
    secondary_damping: float = quantity(2.0e4, "N s/m", "Damping of the secondary suspension of a side", 1e2, 1e6)


class Track(Group):
    """The track under all wheels."""

    spectrum: Literal["none", "erri_low", "erri_high", "fra_1", "fra_2", "fra_3", "fra_4", "fra_5", "fra_6"] = Field(
        "erri_low",
        description="Irregularity: the spectrum of ERRI B176, of a class of the FRA (6 is the smoothest), or none",
        json_schema_extra={"unit": "-", "symbol": "", "remedy": "", "run_time": False},
    )
    roughness: float = quantity(8.0, "dB", "Roughness of rails and wheels at 0.1 m, re 1 um; -40 for smooth ones", -40.0, 30.0)
    joint_spacing: float = length(0.0, "Distance of the joints of a rail; 0 for welded rails", 0.0, 1000.0)
    joint_rail: Literal["both", "left", "right"] = choice("both", "Rails with joints")
    joint_angle: float = quantity(0.004, "rad", "Half the kink of a joint or crossing", 0.0, 0.03)
    crossings: str = choice("", "Places of single kinks, from the start of the run, and their rail, such as '350 left, 900 right' [m]")
    corrugation: str = choice("", "Wavelength and amplitude of a corrugated rail, such as '0.05 10e-6 left' [m]")
    seed: int = quantity(7, "-", "Seed of irregularity and roughness", 0, 2**31 - 1)

    @model_validator(mode="after")
    def _has_rails_between_joints(self) -> Track:
        if 0.0 < self.joint_spacing < SHORTEST_RAIL:
            raise Contradictions(
                [f"joint_spacing = {self.joint_spacing:g} m is outside {SHORTEST_RAIL:g} .. 1000 m: give 0 for welded rails"]
            )
        return self


class Paths(Group):
    """Levels of the vibration of a bearing at other boxes above 200 Hz, over the box at the source [dB].

    Each has five numbers, for 0.2 .. 0.5, 0.5 .. 1, 1 .. 2, 2 .. 5 and above 5 kHz.
    """

    same_wheelset: str = choice("-27, -13, -20, -25, -30", "The other box of the wheelset [dB]")
    same_side: str = choice("-30, -24, -35, -40, -40", "The box of the other wheelset on this side [dB]")
    diagonal: str = choice("-38, -24, -40, -45, -45", "The box across [dB]")
    seed: int = quantity(3, "-", "Seed of the paths of this vehicle", 0, 2**31 - 1)


class Gear(Group):
    """The gear of a driven wheelset."""

    teeth: int = quantity(0, "-", "Teeth of the wheel on the axle; 0 for a wheelset that is not driven", 0, 200)
    level: float = quantity(3.0, "m/s^2", "Acceleration of a rigid wheelset by the force at the mesh frequency, rms", 0.0, 100.0)
    modulation: float = quantity(0.2, "-", "Modulation of the mesh once per revolution of the axle, by run-out of the gear", 0.0, 1.0)
    position: float = length(0.35, "Place of gear and motor on the axle, left of its middle", -0.7, 0.7)


class Motor(Group):
    """The motor of a driven wheelset, which hangs on its axle at the place of the gear."""

    level: float = quantity(0.0, "m/s^2", "Acceleration of a rigid wheelset by the force at twice the supply frequency, rms", 0.0, 100.0)
    ratio: float = quantity(4.14, "-", "Revolutions of the motor per revolution of the axle", 0.1, 20.0)
    pole_pairs: int = quantity(2, "-", "Pairs of poles of the motor", 1, 12)
    slip: float = quantity(0.01, "-", "Slip of the rotor behind the field of the supply; below zero while it brakes", -0.1, 0.1)


class Wheel(Group):
    """The defects of a wheel."""

    unbalance: float = quantity(0.0, "kg m", "Unbalance; wheels are accepted up to some 0.075", 0.0, 1.0, remedy="75 g m are 0.075")
    flat: float = length(0.0, "Length of a flat", 0.0, 0.1)
    flat_worn: float = quantity(0.5, "-", "Share of the jump of a fresh flat that a worn one has", 0.1, 1.0)
    polygon: str = choice("", "Orders and amplitudes of an out-of-round wheel, such as '3 20e-6' or '1 1e-4, 3 20e-6' [m]")

    @property
    def defective(self) -> bool:
        """Whether it has any defect."""
        return self.unbalance > 0.0 or self.flat > 0.0 or bool(self.polygon)


@dataclass(frozen=True)
class Axle:
    """A wheelset."""

    name: str
    x: float
    """Place in the bogie, forward positive [m]."""
    radius: float
    """Radius of its wheels [m]."""
    creep: float
    """Share by which the wheels turn faster than they roll [-]."""
    slide: float
    """Share by which the wheels slide at the start, turning slower than they roll [-]."""
    gear: Gear
    motor: Motor


@dataclass(frozen=True)
class Box:
    """An axle box with its bearing and its wheel."""

    name: str
    """Such as ``axle_1.left``."""
    axle: int
    """Number of its wheelset, from 0 [-]."""
    side: int
    """1 on the left, -1 on the right [-]."""
    configuration: Configuration
    wheel: Wheel
    swapped_with: str = ""
    """The box whose accelerometer is connected to this box's channel; empty for its own."""


@dataclass(frozen=True)
class Vehicle:
    """A bogie: its groups of parameters, wheelsets and boxes."""

    journey: Journey
    body: Body
    frame: Frame
    suspension: Suspension
    track: Track
    paths: Paths
    axles: tuple[Axle, ...]
    boxes: tuple[Box, ...]

    @property
    def static_load(self) -> float:
        """Load of a box by the weight of body and frame [N]."""
        return (0.5 * self.body.mass + self.frame.mass) * GRAVITY / 4.0


def numbers(text: str, count: int, where: str) -> tuple[float, ...]:
    """Return the numbers in a text, separated by commas or spaces.

    Raises:
        Refusal: there are not ``count`` numbers.
    """
    try:
        values = tuple(float(part) for part in re.split(r"[,\s]+", text.strip()))
    except ValueError:
        values = ()
    if len(values) != count or not all(abs(value) < 1e6 for value in values):
        raise Refusal(f"{where} = '{text}' is not {count} numbers: separate them with commas")
    return values


def orders(text: str, where: str) -> list[tuple[int, float]]:
    """Return the orders and amplitudes [m] in a text such as ``1 1e-4, 3 20e-6``.

    Raises:
        Refusal: an item is not a whole order of 1 .. 40 with an amplitude up to 1 mm.
    """
    listed = []
    for part in filter(None, (part.strip() for part in text.split(","))):
        order, height = numbers(part, 2, where)
        if order != round(order) or not (1 <= order <= 40 and 0.0 < height <= 1e-3):
            raise Refusal(f"{where} = '{text}': give whole orders of 1 .. 40, each with an amplitude up to 0.001 m, such as '3 20e-6'")
        listed.append((round(order), height))
    return listed


def places(text: str, where: str) -> list[tuple[float, str]]:
    """Return the numbers and rails in a text such as ``350 left, 900 right``.

    Raises:
        Refusal: an item is not a place of 0 m or more with left or right.
    """
    listed = []
    for part in filter(None, (part.strip() for part in text.split(","))):
        match = re.fullmatch(r"([0-9.eE+]+)\s+(left|right)", part)
        try:
            place = float(match[1]) if match else -1.0
        except ValueError:
            place = -1.0
        if match is None or not 0.0 <= place < math.inf:
            raise Refusal(f"{where}: '{part}' is not a place with a rail: give for example '350 left, 900 right' [m]")
        listed.append((place, match[2]))
    return listed


def levels(text: str, count: int, where: str) -> Sequence[float]:
    """Return levels of bands [dB].

    Raises:
        Refusal: there are not ``count`` numbers from -120 to -6 dB.
    """
    values = numbers(text, count, where)
    loud = next((value for value in values if not -120.0 <= value <= -6.0), None)
    if loud is not None:
        raise Refusal(f"{where}: {loud:g} dB is outside -120 .. -6 dB: a path takes energy from its source")
    return values


def described(vehicle: Vehicle) -> VehicleDescription:
    """Return the description of a vehicle for a detector: geometry, bearings and sampling, and nothing about faults."""
    axles = tuple(AxleDescription(axle.name, axle.x, axle.radius, axle.gear.teeth) for axle in vehicle.axles)
    boxes = tuple(
        BoxDescription(
            box.name.replace(".", "/"),
            vehicle.axles[box.axle].name,
            "left" if box.side > 0 else "right",
            characteristic_orders(box.configuration.bearing).as_dict(),
            box.configuration.bearing.model_dump(),
            box.configuration.sensor.range,
        )
        for box in vehicle.boxes
    )
    return VehicleDescription(vehicle.boxes[0].configuration.sensor.sampling_rate, axles, boxes)

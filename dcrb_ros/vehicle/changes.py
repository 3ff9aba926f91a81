"""Changes of a running vehicle by dotted keys: to parameters of boxes, to wheels, and to the slides of wheelsets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.files import validated
from dcrb_ros.vehicle.description import Vehicle, Wheel, orders
from dcrb_ros.vehicle.file import MOST_SLIDING, ONE_BOX, SHARE, SWAPPED, as_floats, made_by_vehicle

RANGES = {
    "speed_kmh": (5.0, 300.0, "km/h"),
    "curvature": (-0.01, 0.01, "1/m"),
    "cant": (0.0, 0.18, "m"),
    "wind": (-1e5, 1e5, "N"),
    "brake": (0.0, 1.5, "m/s^2"),
}
"""Commands, their ranges and units."""


def checked_command(name: str, value: Any, where: str = "", end: str = "") -> float:
    """Return the value of a command; ``where`` begins and ``end`` completes each refusal.

    Raises:
        Refusal: the command is unknown, or the value out of range.
    """
    if name not in RANGES:
        raise Refusal(f"{where}there is no command '{name}'{nearest(name, RANGES)} (known: {', '.join(RANGES)})")
    low, high, unit = RANGES[name]
    try:
        number = finite_number(f"{where}{name} =", value, unit)
    except Refusal as refusal:
        raise Refusal(f"{refusal}; the range is {low:g} .. {high:g} {unit}") from None
    if not low <= number <= high:
        raise Refusal(f"{where}{name} = {value:g} {unit} is outside {low:g} .. {high:g} {unit}{end}")
    return number


@dataclass
class VehicleChanges:
    """Changes that were asked for at the same time."""

    boxes: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Parameters of each box by dotted keys."""
    wheels: dict[str, Wheel] = field(default_factory=dict)
    """The defects of the wheel under a box."""
    slides: dict[str, float] = field(default_factory=dict)
    """Share by which a wheelset is to slide [-]."""

    @property
    def of_model(self) -> bool:
        """Whether they change wheels or slides, which the model of the vehicle has."""
        return bool(self.wheels or self.slides)


def sorted_changes(vehicle: Vehicle, wheels: Mapping[str, Wheel], changes: Mapping[str, Any], where: str = "") -> VehicleChanges:
    """Return changes by what they change; ``wheels`` are the present ones, and ``where`` begins each refusal.

    The values of parameters of boxes are not checked.

    Raises:
        Refusal: a key names no box or wheelset, belongs to the vehicle or cannot change, or a value is out of range.
    """
    sorted_ = VehicleChanges()
    worn: dict[str, dict[str, Any]] = {}
    names, axles = [box.name for box in vehicle.boxes], [axle.name for axle in vehicle.axles]
    for key, value in changes.items():
        axle, _, rest = key.partition(".")
        side, _, parameter = rest.partition(".")
        name = f"{axle}.{side}"
        if axle in axles and rest == "slide":
            slide = finite_number(f"{where}{key} =", value, SHARE)
            if not 0.0 <= slide <= MOST_SLIDING:
                raise Refusal(f"{where}{key} = {slide:g} is outside 0 .. {MOST_SLIDING:g}: give the share by which the wheels turn slower")
            sorted_.slides[axle] = slide
            continue
        if name not in names or not parameter:
            known = [*names, *(f"{axle}.slide" for axle in axles)]
            raise Refusal(f"{where}'{key}' names no box{nearest(name, known)} (known: {', '.join(known)})")
        owner = made_by_vehicle(parameter)
        if owner:
            raise Refusal(f"{where}'{key}' belongs to the vehicle: it follows from {owner}; command {', '.join(RANGES)}")
        if parameter == "wheel":
            defects = ", ".join(f"{key}.{defect}" for defect in Wheel.model_fields)
            raise Refusal(f"{where}'{key}' is a group of parameters: give one of {defects}")
        if parameter in (SWAPPED, "bench"):
            raise Refusal(f"{where}'{key}' cannot change during a run: give it in the vehicle's file")
        if parameter.startswith("wheel."):
            worn.setdefault(name, {})[parameter.removeprefix("wheel.")] = value
        else:
            sorted_.boxes.setdefault(name, {})[parameter] = value
    for name, given in worn.items():
        values = {**wheels[name].model_dump(), **as_floats(given, Wheel)}
        sorted_.wheels[name] = wheel = validated(values, Wheel, f"{where}{name}.wheel")
        orders(wheel.polygon, f"{where}{name}.wheel.polygon")
        axle = name.partition(".")[0]
        if wheel.defective and sum(box.startswith(f"{axle}.") for box in names) == 1:
            raise Refusal(f"{where}{name}.wheel: {axle} {ONE_BOX}")
    return sorted_

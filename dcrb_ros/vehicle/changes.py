"""Changes of a running vehicle by dotted keys: to parameters of boxes, to wheels, and to the slides of wheelsets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.files import validated
from dcrb_ros.vehicle.description import Vehicle, Wheel, orders
from dcrb_ros.vehicle.file import DRIVE, GROUPS, MOST_SLIDING, ONE_BOX, PLACES, RUN, SHARE, SWAPPED, as_floats, made_by_vehicle

RANGES = {
    "speed_kmh": (5.0, 300.0, "km/h"),
    "curvature": (-0.01, 0.01, "1/m"),
    "cant": (0.0, 0.18, "m"),
    "wind": (-1e5, 1e5, "N"),
    "brake": (0.0, 1.5, "m/s^2"),
}
"""Commands, their ranges and units."""
FIXED = "cannot change during a run: give it in the vehicle's file"
"""Why a parameter is refused."""


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


def of_model(key: str) -> bool:
    """Return whether the key of a valid change names a wheel or a slide, which the model of the vehicle has, not a parameter of a box."""
    parts = key.split(".")
    return len(parts) == 2 or parts[2] == "wheel"


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
            raise Refusal(f"{where}'{key}' {_beside_boxes(key, names, axles)}")
        check_own(parameter, f"{where}'{key}'")
        if parameter == "wheel":
            defects = ", ".join(f"{key}.{defect}" for defect in Wheel.model_fields)
            raise Refusal(f"{where}'{key}' is a group of parameters: give one of {defects}")
        if parameter in (SWAPPED, "bench"):
            raise Refusal(f"{where}'{key}' {FIXED}")
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


def check_own(parameter: str, said: str) -> None:
    """Refuse a parameter of a box that it cannot have of its own; ``said`` begins the refusal."""
    owner = made_by_vehicle(parameter)
    if owner:
        moving = parameter.partition(".")[0] == "operating"
        remedy = f"command {', '.join(RANGES)}" if moving else "change the wheel of the box, or give track and gear in the vehicle's file"
        raise Refusal(f"{said} belongs to the vehicle: it follows from {owner}; {remedy}")
    if parameter.startswith(RUN):
        raise Refusal(f"{said} belongs to the whole vehicle: give {parameter} beside the group vehicle in its file")


def _beside_boxes(key: str, names: Sequence[str], axles: Sequence[str]) -> str:
    """Return why a key that is neither a parameter of a box nor a slide is refused."""
    group, _, rest = key.partition(".")
    if key in names:
        return f"is a box: give one of its parameters, such as {key}.faults.outer_1.width"
    if group == "vehicle" and rest in RANGES:
        return f"is a command: give it as {rest} to command"
    of_axle = {*PLACES, *(f"{part}.{name}" for part, model in DRIVE.items() for name in model.model_fields)}
    if rest in (of_axle if group in axles else GROUPS[group].model_fields if group in GROUPS else ()):
        return FIXED
    name, known = ".".join(key.split(".")[:2]), [*names, *(f"{axle}.slide" for axle in axles)]
    return f"names no box{nearest(name, known)} (known: {', '.join(known)})"

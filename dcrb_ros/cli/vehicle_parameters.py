"""The parameters of a vehicle's file as one group, for the documentation and `dcrb config docs`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import create_model

from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.vehicle.description import Wheel
from dcrb_ros.vehicle.file import DEFAULT_RADIUS, DEFAULT_X, DRIVE, GROUPS, PLACES

WHEELSET = {
    "x": (DEFAULT_X["axle_1"], f"Place in the bogie, forward positive; the default of axle_2 is {DEFAULT_X['axle_2']:g}"),
    "radius": (DEFAULT_RADIUS, "Radius of its wheels"),
    "creep": (0.0, "Share by which the wheels turn faster than they roll"),
    "slide": (0.0, "Share by which the wheels slide at the start, turning slower than they roll"),
}
"""Default and meaning of the numbers of a wheelset."""


def vehicle_parameters() -> type[Group]:
    """Return the parameters of a vehicle; ``axle_1`` and its left box stand for both wheelsets and all boxes."""
    wheelset: dict[str, Any] = {}
    for key, (low, high, unit) in PLACES.items():
        default, meaning = WHEELSET[key]
        wheelset[key] = (float, quantity(default, unit, meaning, low, high))
    wheelset |= _fields(DRIVE) | _fields({"left": _model("Side", _fields({"wheel": Wheel}))})
    return _model("VehicleParameters", _fields({**GROUPS, "axle_1": _model("Wheelset", wheelset)}))


def _model(name: str, fields: Mapping[str, Any]) -> type[Group]:
    return create_model(name, __base__=Group, **fields)


def _fields(groups: Mapping[str, type[Group]]) -> dict[str, Any]:
    return {key: (group, group()) for key, group in groups.items()}

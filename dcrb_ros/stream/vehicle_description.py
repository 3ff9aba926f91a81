"""The description of a vehicle: what a detector has to know to compare the axle boxes, and no truth about their faults."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from dcrb_ros.schema.refusal import Refusal, repeated

FORMAT = "dcrb vehicle 1"
"""Format of the description in JSON."""
SOURCE = "the vehicle's description"
LARGEST_DESCRIPTION = 100_000
"""Longest description that is read [characters]; that of a bogie has some 3000."""
MOST_BOXES = 8
"""Boxes of a vehicle at most [-]."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
"""Name of a wheelset: a token of a ROS name."""
SIDES = ("left", "right")
ORDERS = ("FTF", "BPFO", "BPFI", "BSF")
"""Characteristic orders of a bearing."""
RATES = (1000, 1_000_000)
"""Range of the sampling rate [Hz]."""
RANGES = {
    "x": (-100.0, 100.0, "m"),
    "wheel_radius": (0.1, 1.0, "m"),
    "sensor_range": (0.0, 1e6, "m/s^2"),
    "order": (0.01, 1000.0, "orders"),
}
"""Ranges of the numbers and their units."""
MOST_TEETH = 1000
"""[-]"""


@dataclass(frozen=True)
class AxleDescription:
    """A wheelset."""

    name: str
    """Such as ``axle_1``."""
    x: float
    """Place along the vehicle, forward positive [m]."""
    wheel_radius: float
    """Radius of its wheels [m]."""
    gear_teeth: int = 0
    """Teeth of the gear wheel on the axle; 0 if it has none [-]."""

    @property
    def driven(self) -> bool:
        """Whether a motor drives it through the gear."""
        return self.gear_teeth > 0


@dataclass(frozen=True)
class BoxDescription:
    """An axle box with its sensor and bearing."""

    name: str
    """Such as ``axle_1/left``."""
    axle: str
    """Name of its wheelset."""
    side: Literal["left", "right"]
    orders: Mapping[str, float]
    """FTF, BPFO, BPFI and BSF of its bearing as multiples of the shaft frequency [-]."""
    bearing: Mapping[str, float | int | str]
    """Geometry of the bearing, as the description of the sensor has it; may be empty."""
    sensor_range: float = 0.0
    """Range of the sensor [m/s^2]; 0 if it is not known."""


@dataclass(frozen=True)
class VehicleDescription:
    """Wheelsets and axle boxes of a vehicle, sampled on one clock.

    Raises:
        Refusal: a name, a number or the set of boxes is impossible.
    """

    sampling_rate: int
    """[Hz]"""
    axles: tuple[AxleDescription, ...]
    boxes: tuple[BoxDescription, ...]

    def __post_init__(self) -> None:
        low, high = RATES
        if not _is_whole(self.sampling_rate, low, high):
            raise Refusal(f"{SOURCE}: sampling_rate = {self.sampling_rate!r} is not a whole number of {low} .. {high} Hz")
        for axle in self.axles:
            _check_axle(axle)
        names = [axle.name for axle in self.axles]
        _refuse_repeated(names, "wheelsets")
        places = [axle.x for axle in self.axles]
        if len(set(places)) < len(places):
            raise Refusal(f"{SOURCE}: two wheelsets are at one x: give them places of their own")
        if not 1 <= len(self.boxes) <= MOST_BOXES:
            raise Refusal(f"{SOURCE} has {len(self.boxes)} boxes: give 1 to {MOST_BOXES}")
        for box in self.boxes:
            _check_box(box, names)
        _refuse_repeated([box.name for box in self.boxes], "boxes")

    def box(self, name: str) -> BoxDescription:
        """Return the box of a name.

        Raises:
            Refusal: there is none.
        """
        found = next((box for box in self.boxes if box.name == name), None)
        if found is None:
            raise Refusal(f"there is no box '{name}' (known: {', '.join(box.name for box in self.boxes)})")
        return found

    @property
    def partners(self) -> dict[str, str]:
        """The other box of the wheelset of each box that has one."""
        return {box.name: other.name for box in self.boxes for other in self.boxes if other.axle == box.axle and other != box}

    def axle(self, name: str) -> AxleDescription:
        """Return the wheelset of a name, which must be one of a box."""
        return next(axle for axle in self.axles if axle.name == name)

    def to_json(self) -> str:
        """Return the description in JSON."""
        return json.dumps({"format": FORMAT, **asdict(self)}, sort_keys=True)

    @staticmethod
    def from_json(text: str | bytes) -> VehicleDescription:
        """Return the description in a JSON text; unknown keys are ignored, so that others may add some.

        Raises:
            Refusal: the text is not a description, or describes no possible vehicle.
        """
        if len(text) > LARGEST_DESCRIPTION:
            raise Refusal(f"{SOURCE} has {len(text)} characters; at most {LARGEST_DESCRIPTION} are read")
        try:
            about = json.loads(text)
        except (ValueError, RecursionError):
            about = None
        if not isinstance(about, Mapping) or about.get("format") != FORMAT:
            raise Refusal(f"{SOURCE} is not JSON with format '{FORMAT}': publish what VehicleDescription.to_json returns")
        try:
            axles = tuple(
                AxleDescription(item["name"], _number(item["x"]), _number(item["wheel_radius"]), item.get("gear_teeth", 0))
                for item in about["axles"]
            )
            boxes = tuple(
                BoxDescription(
                    item["name"],
                    item["axle"],
                    item["side"],
                    {name: _number(item["orders"][name]) for name in ORDERS},
                    dict(item.get("bearing", {})),
                    _number(item.get("sensor_range", 0.0)),
                )
                for item in about["boxes"]
            )
            rate = about["sampling_rate"]
        except KeyError as error:
            raise Refusal(f"{SOURCE} lacks {error}: give sampling_rate, axles and boxes") from None
        except (TypeError, ValueError, AttributeError, OverflowError) as error:
            raise Refusal(f"{SOURCE} cannot be decoded ({type(error).__name__}): give sampling_rate, axles and boxes") from None
        return VehicleDescription(rate, axles, boxes)


def _number(value: Any) -> float:
    """Return a number from JSON; raise `TypeError` for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError
    return float(value)


def _is_whole(value: object, low: int, high: int) -> bool:
    """Return whether a value is a whole number from ``low`` to ``high``."""
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def _check_axle(axle: AxleDescription) -> None:
    """Refuse an impossible wheelset."""
    if not isinstance(axle.name, str) or not NAME.fullmatch(axle.name):
        raise Refusal(f"{SOURCE}: wheelset {axle.name!r} has no name of letters, digits and '_': call it for example axle_1")
    _check_number(f"{axle.name}.x", axle.x, "x")
    _check_number(f"{axle.name}.wheel_radius", axle.wheel_radius, "wheel_radius")
    if not _is_whole(axle.gear_teeth, 0, MOST_TEETH):
        raise Refusal(f"{SOURCE}: {axle.name}.gear_teeth = {axle.gear_teeth!r} is not a whole number of 0 .. {MOST_TEETH}")


def _check_box(box: BoxDescription, axles: list[str]) -> None:
    """Refuse an impossible box."""
    if box.axle not in axles:
        raise Refusal(f"{SOURCE}: the wheelset {box.axle!r} of box {box.name!r} is unknown (known: {', '.join(axles)})")
    if box.side not in SIDES:
        raise Refusal(f"{SOURCE}: box {box.name!r} has the side {box.side!r}: give left or right")
    if box.name != f"{box.axle}/{box.side}":
        raise Refusal(f"{SOURCE}: box {box.name!r} must be called '{box.axle}/{box.side}', as its wheelset and side are")
    if set(box.orders) != set(ORDERS):
        raise Refusal(f"{SOURCE}: box {box.name} has orders of {', '.join(box.orders) or 'nothing'}: give {', '.join(ORDERS)}")
    for name, order in box.orders.items():
        _check_number(f"{box.name}, {name}", order, "order")
    _check_number(f"{box.name}.sensor_range", box.sensor_range, "sensor_range")


def _check_number(where: str, value: float, kind: str) -> None:
    """Refuse a number outside its range."""
    low, high, unit = RANGES[kind]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value) or not low <= value <= high:
        raise Refusal(f"{SOURCE}: {where} = {value!r} is outside {low:g} .. {high:g} {unit}")


def _refuse_repeated(names: list[str], kind: str) -> None:
    """Refuse names that occur twice."""
    if (twice := repeated(names)) is not None:
        raise Refusal(f"{SOURCE}: two {kind} are called '{twice}': give them different names")

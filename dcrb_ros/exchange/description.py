"""The description of a foreign waveform: what its file does not say, and nobody may guess."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError

from dcrb_ros.bearing.kinematics import Orders, characteristic_orders
from dcrb_ros.runtime.refusal import Refusal, nearest
from dcrb_ros.schema.fields import Group
from dcrb_ros.settings.yaml import read_yaml

UNITS = {"m/s^2": 1.0, "g": 9.80665, "mm/s^2": 1e-3}
"""Units of acceleration in m/s^2."""


def _whole(given: Any) -> Any:
    """Return a decimal number that is a whole one, such as 5.12e4, as that."""
    return int(given) if isinstance(given, float) and given.is_integer() else given


def _plain(given: Any) -> Any:
    """Return labels as JSON can say them: a date, as a key too, becomes its text."""
    if isinstance(given, Mapping):
        return {str(key): _plain(value) for key, value in given.items()}
    if isinstance(given, (list, tuple)):
        return [_plain(value) for value in given]
    if isinstance(given, float) and not math.isfinite(given):
        raise ValueError(f"{given} is no finite number; write null for what is not known")
    return given if given is None or isinstance(given, (bool, int, float, str)) else str(given)


Whole = Annotated[int, BeforeValidator(_whole)]
Labels = Annotated[dict[str, Any], BeforeValidator(_plain)]


class Channels(Group):
    """Where the channels stand: a column, a variable, or a number from 1."""

    ax: str | int
    """Acceleration of the first axis."""
    ay: str | int | None = None
    """Acceleration of the second axis; without one it is a copy of the first."""
    shaft_angle: str | int | None = None
    """Angle of the shaft [rad]; without one it follows from the speed."""
    index: str | int | None = None
    """Index of each sample; without one they follow each other without a gap."""


class Geometry(Group):
    """What the fault orders follow from; with a contact angle give the orders themselves."""

    rollers_per_row: int = Field(ge=3, le=200)
    roller_radius: float = Field(gt=0.0)
    """[m]"""
    pitch_radius: float = Field(gt=0.0)
    """[m]"""


class GivenOrders(Group):
    """Characteristic frequencies over the shaft frequency [-]."""

    FTF: float = Field(gt=0.0, le=1000.0)
    BPFO: float = Field(gt=0.0, le=1000.0)
    BPFI: float = Field(gt=0.0, le=1000.0)
    BSF: float = Field(gt=0.0, le=1000.0)


class Description(Group):
    """What a foreign waveform is of."""

    channels: Channels
    sampling_rate: Whole | None = Field(None, ge=100, le=10_000_000)
    """[Hz]"""
    unit: Literal["m/s^2", "g", "mm/s^2"] | None = None
    full_scale: float | None = Field(None, gt=0.0)
    """What the largest number of a WAV file of integers stands for, in the unit."""
    speed: float | None = Field(None, ge=-1e5, le=1e5)
    """Speed of the shaft [rad/s]."""
    speed_rpm: float | None = Field(None, ge=-1e6, le=1e6)
    bearing: Geometry | None = None
    orders: GivenOrders | None = None
    first_index: Whole = Field(0, ge=0)
    block_size: Whole = Field(1024, ge=16, le=65536)
    labels: Labels = Field(default_factory=dict)
    """Whatever is known of the truth; kept, not used."""

    def fault_orders(self, source: Path) -> Orders:
        """Return the characteristic orders.

        Raises:
            Refusal: neither geometry nor orders are given.
        """
        if self.orders is not None:
            return Orders.from_dict(self.orders.model_dump())
        if self.bearing is None:
            raise Refusal(f"{source} gives neither bearing nor orders: name the geometry, or FTF, BPFO, BPFI and BSF")
        b = self.bearing
        if b.roller_radius >= b.pitch_radius:
            raise Refusal(f"{source}: bearing.roller_radius = {b.roller_radius:g} m must be below pitch_radius = {b.pitch_radius:g} m")
        return characteristic_orders(b)

    def shaft_speed(self, source: Path) -> float:
        """Return the speed of the shaft [rad/s].

        Raises:
            Refusal: none is given, or two are.
        """
        if (self.speed is None) == (self.speed_rpm is None):
            raise Refusal(f"{source} must give speed in rad/s, or speed_rpm, or a channel shaft_angle; a speed is never guessed")
        if self.speed is not None:
            return self.speed
        return (self.speed_rpm or 0.0) * 0.10471975511965977  # pi / 30

    def factor(self, source: Path) -> float:
        """Return the unit in m/s^2.

        Raises:
            Refusal: none is given.
        """
        if self.unit is None:
            raise Refusal(f"{source} gives no unit: add unit, one of {', '.join(UNITS)}; it is never guessed")
        return UNITS[self.unit]


def read_description(path: Path) -> Description:
    """Return the description in a YAML file.

    Raises:
        Refusal: it cannot be read, or a key is unknown, missing or out of range.
    """
    tree = read_yaml(path)
    if not isinstance(tree, dict):
        raise Refusal(f"{path} is no description: it must give channels, unit, sampling_rate, a speed and a bearing")
    for key in tree:
        if key not in Description.model_fields:
            raise Refusal(f"{path}: unknown key '{key}'{nearest(str(key), Description.model_fields)}")
    try:
        return Description.model_validate(tree)
    except RecursionError:
        raise Refusal(f"{path}: the labels are nested too deeply, or hold themselves: make them flatter") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        given = "" if first["type"] == "missing" else f" = {first['input']!r}"
        words = first["msg"].removeprefix("Value error, ")
        raise Refusal(f"{path}: {key}{given} is refused: {words[0].lower()}{words[1:]}") from None

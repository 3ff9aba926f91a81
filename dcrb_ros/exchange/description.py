"""The description of an external waveform: the information that is not in its file and is never guessed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError

from dcrb_ros.bearing.kinematics import HIGHEST_ORDER, LOWEST_ORDER, Orders, characteristic_orders
from dcrb_ros.bearing.order_check import order_mistake
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.numbers import HIGHEST_RATE
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.units import ACCELERATION_UNITS
from dcrb_ros.text.yaml import read_yaml


def _whole(given: Any) -> Any:
    """Return a float with an integer value, such as 5.12e4, as int; anything else unchanged."""
    return int(given) if isinstance(given, float) and given.is_integer() else given


def _plain(given: Any) -> Any:
    """Return labels in a form that JSON can represent: dates, also as keys, become text."""
    if isinstance(given, Mapping):
        return {str(key): _plain(value) for key, value in given.items()}
    if isinstance(given, (list, tuple)):
        return [_plain(value) for value in given]
    if isinstance(given, float) and not math.isfinite(given):
        raise ValueError(f"{given} is not a finite number: write null for an unknown value")
    return given if given is None or isinstance(given, (bool, int, float, str)) else str(given)


Whole = Annotated[int, BeforeValidator(_whole)]
Labels = Annotated[dict[str, Any], BeforeValidator(_plain)]


class Channels(Group):
    """The names of the channels: a column, a variable, or a column number from 1."""

    ax: str | int
    """Acceleration of the first axis."""
    ay: str | int | None = None
    """Acceleration of the second axis; if omitted, a copy of the first."""
    shaft_angle: str | int | None = None
    """Angle of the shaft [rad]; if omitted, computed from the speed."""
    index: str | int | None = None
    """Index of each sample; if omitted, the samples have no gaps."""


class Geometry(Group):
    """The geometry from which the fault orders are computed; for a bearing with a contact angle, give the orders instead."""

    rollers_per_row: int = Field(ge=3, le=200)
    roller_radius: float = Field(gt=0.0)
    """[m]"""
    pitch_radius: float = Field(gt=0.0)
    """[m]"""


class GivenOrders(Group):
    """Characteristic frequencies as multiples of the shaft frequency [-]."""

    FTF: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BPFO: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BPFI: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BSF: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)


class Description(Group):
    """The description of an external waveform."""

    channels: Channels
    sampling_rate: Whole | None = Field(None, ge=100, le=HIGHEST_RATE)
    """[Hz]"""
    unit: Literal["m/s^2", "g", "mm/s^2"] | None = None
    full_scale: float | None = Field(None, gt=0.0)
    """Acceleration that corresponds to the largest number of a WAV file with integer samples [unit]."""
    speed: float | None = Field(None, ge=-1e5, le=1e5)
    """Speed of the shaft [rad/s]."""
    speed_rpm: float | None = Field(None, ge=-1e6, le=1e6)
    bearing: Geometry | None = None
    orders: GivenOrders | None = None
    first_index: Whole = Field(0, ge=0)
    block_size: Whole = Field(1024, ge=16, le=65536)
    labels: Labels = Field(default_factory=dict)
    """Known ground truth in any form; it is stored but not used."""

    def fault_orders(self, source: Path) -> Orders:
        """Return the characteristic orders of the bearing [-].

        Raises:
            Refusal: neither geometry nor orders are given, or the orders contradict each other.
        """
        if self.orders is not None:
            orders = Orders.from_dict(self.orders.model_dump())
            mistake = order_mistake(orders)
            if mistake:
                raise Refusal(f"{source}: orders: {mistake}")
            return orders
        if self.bearing is None:
            raise Refusal(f"{source} has neither bearing nor orders: give the geometry, or the orders FTF, BPFO, BPFI and BSF")
        b = self.bearing
        if b.roller_radius >= b.pitch_radius:
            raise Refusal(f"{source}: bearing.roller_radius = {b.roller_radius:g} m must be below pitch_radius = {b.pitch_radius:g} m")
        try:
            return characteristic_orders(b)
        except Refusal as refusal:
            raise Refusal(f"{source}: bearing: {refusal}") from None

    def shaft_speed(self, source: Path) -> float:
        """Return the speed of the shaft [rad/s], NaN if it is not given.

        Raises:
            Refusal: both `speed` and `speed_rpm` are given.
        """
        if self.speed is None and self.speed_rpm is None:
            return math.nan
        if self.speed is not None and self.speed_rpm is not None:
            raise Refusal(f"{source} gives speed in rad/s and speed_rpm: give one of them, or neither if the speed is unknown")
        if self.speed is not None:
            return self.speed
        return (self.speed_rpm or 0.0) * 0.10471975511965977  # pi / 30

    @property
    def speedless(self) -> bool:
        """Whether no speed is given."""
        return self.speed is None and self.speed_rpm is None

    def factor(self, source: Path) -> float:
        """Return the unit of the acceleration in m/s^2.

        Raises:
            Refusal: no unit is given.
        """
        if self.unit is None:
            raise Refusal(f"{source} has no unit: add unit, one of {', '.join(ACCELERATION_UNITS)}; it is never guessed")
        return ACCELERATION_UNITS[self.unit]


def read_description(path: Path) -> Description:
    """Return the description in a YAML file.

    Raises:
        Refusal: it cannot be read, or a key is unknown, missing or out of range.
    """
    tree = read_yaml(path)
    if not isinstance(tree, dict):
        raise Refusal(f"{path} is not a description: it must have the keys channels, unit, sampling_rate, speed and bearing or orders")
    for key in tree:
        if key not in Description.model_fields:
            raise Refusal(f"{path}: unknown key '{key}'{nearest(str(key), Description.model_fields)}")
    try:
        return Description.model_validate(tree)
    except RecursionError:
        raise Refusal(f"{path}: the labels are nested too deeply or contain themselves: flatten them") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        given = "" if first["type"] == "missing" else f" = {first['input']!r}"
        reason = first["msg"].removeprefix("Value error, ")
        raise Refusal(f"{path}: {key}{given} is refused: {reason[0].lower()}{reason[1:]}") from None

"""The description of an external waveform: information that its file lacks and that is never guessed."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BeforeValidator, Field, ValidationError, field_validator, model_validator

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exchange.bearing import Geometry, GivenOrders, fault_orders
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.numbers import HIGHEST_RATE
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.units import ACCELERATION_UNITS
from dcrb_ros.stream.axes import AXES
from dcrb_ros.text.yaml import parsed, read_yaml

VOLTS = {"V": 1.0, "mV": 1e-3}
"""Units of voltage [V]."""
RELATIVE = "relative"
"""Unit of a waveform whose unit is unknown."""
UNITS = (*ACCELERATION_UNITS, *VOLTS, RELATIVE)
COPY = "a copy of ax"
"""What the description of a sensor with one axis says of the second."""
LOWEST_RATE = 100
"""Lowest sampling rate [Hz]."""
SENSITIVITY = re.compile(r"((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?) *(m?V)/(g|\(m/s\^2\)|m/s\^2)")
"""A sensitivity with its unit."""


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


def _channel(given: Any) -> Any:
    """Return the name or the number of a channel."""
    if isinstance(given, bool) or not isinstance(given, (str, int)) or given == "" or (isinstance(given, int) and given < 1):
        raise ValueError("a channel is a name, or a number from 1")
    return given


Channel = Annotated[str | int, BeforeValidator(_channel)]
Whole = Annotated[int, BeforeValidator(_whole)]
Labels = Annotated[dict[str, Any], BeforeValidator(_plain)]


class Channels(Group):
    """The names of the channels: a column, a variable, or a column number from 1; ``*`` matches any characters of a name."""

    ax: Channel
    """Acceleration of the first axis."""
    ay: Channel | None = None
    """Acceleration of the second axis; if omitted, a copy of the first."""
    az: Channel | None = None
    """Acceleration of the third axis; if omitted, there are two."""
    shaft_angle: Channel | None = None
    """Angle of the shaft [rad], NaN where unknown."""
    tacho: Channel | None = None
    """Pulses of a tacho, ``pulses_per_turn`` of them per turn, in any unit."""
    rpm: Channel | None = None
    """Speed of the shaft [rpm]: a single value, or values over the same time as the acceleration."""
    index: Channel | None = None
    """Index of each sample; if omitted, the samples have no gaps."""
    outer_ring_temperature: Channel | None = None
    """Readings of a sensor at the outer ring [deg C]: at their ``temperature_time``, one per sample, or fewer over the same time."""
    box_temperature: Channel | None = None
    """Readings of a sensor in the axle box [deg C]."""
    ambient_temperature: Channel | None = None
    """Readings of a sensor in the air [deg C]."""
    temperature_time: Channel | None = None
    """Times of the readings since sample 0 [s]."""

    @model_validator(mode="after")
    def _in_turn(self) -> Channels:
        if self.az is not None and self.ay is None:
            raise ValueError("az is given without ay: name the second of two axes ay")
        return self

    @property
    def axes(self) -> dict[str, str | int]:
        """The channels of the axes that are given."""
        return {name: channel for name in AXES if (channel := getattr(self, name)) is not None}


class Description(Group):
    """The description of an external waveform."""

    channels: Channels
    sampling_rate: float | None = Field(None, ge=LOWEST_RATE, le=HIGHEST_RATE)
    """[Hz]"""
    unit: Literal["m/s^2", "g", "mm/s^2", "V", "mV", "relative"] | None = None
    sensitivity: str | None = None
    """Of a sensor whose output is in V or mV, such as ``100 mV/g``."""
    full_scale: float | None = Field(None, gt=0.0)
    """Value of the largest number of a WAV file with integer samples [unit]."""
    speed: float | None = Field(None, ge=-1e5, le=1e5)
    """Speed of the shaft [rad/s]."""
    speed_rpm: float | None = Field(None, ge=-1e6, le=1e6)
    pulses_per_turn: Whole | None = Field(None, ge=1, le=100_000)
    """Of the tacho, 1 if omitted."""
    tacho_levels: tuple[float, float] | None = Field(None, strict=False)
    """Lower and upper level of the hysteresis of the tacho [unit of its channel]."""
    temperature_deviation: float = Field(0.0, ge=0.0, le=100.0)
    """Standard deviation of a reading of temperature [K], 0 if unknown."""
    gap: float | None = Field(None, ge=0.0, le=1e8)
    """Time between the end of a file and the beginning of the next; 0 if they continue each other [s]."""
    bearing: Geometry | None = None
    orders: GivenOrders | None = None
    first_index: Whole = Field(0, ge=0)
    block_size: Whole = Field(1024, ge=16, le=65536)
    labels: Labels = Field(default_factory=dict)
    """Known ground truth in any form; it is stored but not used."""
    source: Labels = Field(default_factory=dict)
    """Where the data come from, in any form; it is stored but not used."""

    @field_validator("tacho_levels")
    @classmethod
    def _rising(cls, levels: tuple[float, float] | None) -> tuple[float, float] | None:
        if levels is not None and not levels[0] < levels[1]:
            raise ValueError("the lower level comes first, and the two must differ")
        return levels

    def fault_orders(self, source: Path) -> Orders:
        """Return the characteristic orders of the bearing [-].

        Raises:
            Refusal: see `dcrb_ros.exchange.bearing.fault_orders`.
        """
        return fault_orders(self.bearing, self.orders, source)

    def shaft_source(self, source: Path) -> str:
        """Return the origin of the angle of the shaft: a channel, ``speed``, ``speed_rpm`` or the empty string.

        Raises:
            Refusal: there are several, or a property of the tacho is given without it.
        """
        given = [name for name in ("shaft_angle", "tacho", "rpm") if getattr(self.channels, name) is not None]
        given = given if given != ["shaft_angle", "tacho"] else ["shaft_angle"]  # the pulses are recorded beside the angle
        given += [name for name in ("speed", "speed_rpm") if getattr(self, name) is not None]
        if len(given) > 1:
            raise Refusal(f"{source} gives {' and '.join(given)}: give one of them, or neither if the speed is unknown")
        property_ = next((name for name in ("pulses_per_turn", "tacho_levels") if getattr(self, name) is not None), "")
        if property_ and self.channels.tacho is None:
            raise Refusal(f"{source} gives {property_}, but no channel tacho: name the channel of the pulses, or leave it out")
        return given[0] if given else ""

    @property
    def shaft_speed(self) -> float:
        """Stated speed of the shaft [rad/s], NaN if none is given."""
        if self.speed is not None:
            return self.speed
        return math.nan if self.speed_rpm is None else self.speed_rpm * 0.10471975511965977  # pi / 30

    def factor(self, source: Path) -> float:
        """Return the unit of the acceleration in m/s^2; 1 if it is only relative.

        Raises:
            Refusal: no unit is given, or a unit of voltage without a sensitivity, or a sensitivity with another unit.
        """
        if self.unit is None:
            raise Refusal(f"{source} has no unit: add unit, one of {', '.join(UNITS)}; it is never guessed")
        if self.unit in VOLTS:
            return VOLTS[self.unit] / self._volts(source)
        if self.sensitivity is not None:
            raise Refusal(f"{source} gives a sensitivity, but unit = {self.unit}: the unit of an output with a sensitivity is V or mV")
        return ACCELERATION_UNITS.get(self.unit, 1.0)

    def _volts(self, source: Path) -> float:
        """Return the sensitivity [V/(m/s^2)]."""
        parts = SENSITIVITY.fullmatch(self.sensitivity or "")
        value = float(parts[1]) if parts else 0.0
        if parts is None or not 0.0 < value < math.inf:
            given = "no sensitivity" if self.sensitivity is None else f"sensitivity = {self.sensitivity!r}"
            raise Refusal(
                f"{source} has the unit {self.unit} and {given}: give one such as 100 mV/g or 0.01 V/(m/s^2), "
                "or unit: relative if it is unknown"
            )
        return value * VOLTS[parts[2]] / ACCELERATION_UNITS[parts[3].strip("()")]


GROUPS: Mapping[str, type[Group]] = {"": Description, "channels": Channels, "bearing": Geometry, "orders": GivenOrders}
"""The description, and its keys whose values have keys of their own."""


def read_description(path: Path, settings: Sequence[str] = ()) -> Description:
    """Return the description in a YAML file, changed by ``settings`` such as ``speed_rpm=1797`` or ``channels.rpm=null``.

    Raises:
        Refusal: it cannot be read, or a key is unknown, missing or out of range.
    """
    tree = read_yaml(path)
    if not isinstance(tree, dict):
        raise Refusal(f"{path} is not a description: it must have the keys channels, unit, sampling_rate, speed and bearing or orders")
    for setting in settings:
        _change(tree, setting)
    for name, group in GROUPS.items():
        values = tree.get(name) if name else tree
        for key in values if isinstance(values, dict) else ():
            if key not in group.model_fields:
                raise Refusal(f"{path}: unknown key '{name}{'.' * bool(name)}{key}'{nearest(str(key), group.model_fields)}")
    try:
        return Description.model_validate(tree)
    except RecursionError:
        raise Refusal(f"{path}: the labels are nested too deeply or contain themselves: flatten them") from None
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{path}: {problem.key}{problem.value} is refused: {problem.reason}") from None


def _change(tree: dict[str, Any], setting: str) -> None:
    """Set ``KEY=VALUE`` in a description; null removes the key."""
    name, equals, text = setting.partition("=")
    *groups, key = name.strip().split(".")
    if not equals or not key:
        raise Refusal(f"--set {setting} is not KEY=VALUE: give a key of the description, such as speed_rpm=1797")
    for group in groups:
        tree = tree.setdefault(group, {})
        if not isinstance(tree, dict):
            raise Refusal(f"--set {setting}: {group} is not a group of keys: give the whole value")
    try:
        value = parsed(text)
    except yaml.YAMLError:
        raise Refusal(f"--set {setting}: the value is not valid YAML") from None
    if value is None:
        tree.pop(key, None)
    else:
        tree[key] = value

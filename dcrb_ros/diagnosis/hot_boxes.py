"""Rules for the temperatures of all axle boxes of a train, wayside or on board: absolute, over the air, across the axle, across the train.

The set ``us`` has the conventional North American settings, 94.4 K (170 F) over the air and 52.8 K (95 F) over the other box of the axle
(University of Texas Rio Grande Valley, scholarworks.utrgv.edu/me_fac/185). The set ``workshop`` has those by which Italian workshops check
boxes after reports of drivers, 70 deg C and 15 K over the mean of the others (an RTB specification, read in excerpts). The limits of
EN 15437 were not seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from dcrb_ros.schema.fields import Group, choice, quantity

HotBoxRule = Literal["ambient", "opposite", "absolute", "others"]


class HotBoxParameters(Group):
    """The rules for the boxes of a train."""

    rules: Literal["us", "workshop", "both"] = choice("us", "Set of rules: us (ambient, opposite), workshop (absolute, others) or both")
    above_ambient: float = quantity(94.4, "K", "Excess over ambient that is a hot box", 1.0, 500.0)
    above_opposite: float = quantity(52.8, "K", "Excess over the other box of the axle that is a hot box", 1.0, 500.0)
    hottest: float = quantity(70.0, "deg C", "Temperature above which a box is hot", 0.0, 500.0)
    above_others: float = quantity(15.0, "K", "Excess over the mean of the other boxes that is a hot box", 1.0, 500.0)
    slowest: float = quantity(
        30.0, "km/h", "Speed below which boxes are not compared with the mean of the others: there the sun warms a side by more", 0.0, 300.0
    )


@dataclass(frozen=True)
class HotBox:
    """A box that breaks a rule."""

    box: str
    """Such as ``axle_1.left``."""
    rule: HotBoxRule
    excess: float
    """Temperature over the limit of the rule [K]."""
    reason: str


def hot_boxes(readings: Mapping[str, float], ambient: float, speed: float, parameters: HotBoxParameters) -> list[HotBox]:
    """Return the hot boxes among ``readings`` by name [deg C], in their order, at a speed [m/s].

    Names end in ``left`` or ``right``; the other box of an axle has the other end. A box without a reading, NaN, is not judged, and the
    others are judged without it.
    """
    return [hot for box in readings for hot in _broken(box, readings, ambient, speed, parameters) if hot.excess > 0.0]


def _broken(box: str, readings: Mapping[str, float], ambient: float, speed: float, p: HotBoxParameters) -> Iterator[HotBox]:
    """Yield each rule that applies to a box with its excess, which may be below zero."""
    reading, opposite = readings[box], readings.get(opposite_of(box))
    if p.rules != "workshop":
        above = reading - ambient
        yield HotBox(box, "ambient", above - p.above_ambient, f"{box} is {above:.0f} K above ambient")
        if opposite is not None:
            across = reading - opposite
            yield HotBox(box, "opposite", across - p.above_opposite, f"{box} is {across:.0f} K above the other box of the axle")
    if p.rules != "us":
        yield HotBox(box, "absolute", reading - p.hottest, f"{box} has {reading:.0f} deg C")
        others = [value for name, value in readings.items() if name != box and math.isfinite(value)]
        if others and abs(speed) * 3.6 >= p.slowest:
            over = reading - sum(others) / len(others)
            yield HotBox(box, "others", over - p.above_others, f"{box} is {over:.0f} K above the mean of the other boxes")


def opposite_of(box: str) -> str:
    """Return the name of the box at the other end of the axle, such as ``axle_1.right`` for ``axle_1.left``."""
    return box.removesuffix("left") + "right" if box.endswith("left") else box.removesuffix("right") + "left"

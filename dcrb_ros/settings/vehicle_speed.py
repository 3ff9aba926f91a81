"""The two parameters for one speed: of the shaft in rad/s, and of a vehicle in km/h whose wheels turn with it.

``operating.speed_kmh`` is another way to write ``operating.speed``; a validated configuration contains the shaft's speed, and 0 km/h.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dcrb_ros.schema.refusal import Refusal

SPEED, SPEED_KMH = "operating.speed", "operating.speed_kmh"
FASTEST_KMH = 1000.0
"""Largest speed of a vehicle [km/h]."""


def shaft_speed(kmh: float, wheel_diameter: float) -> float:
    """Return the shaft's speed [rad/s] of a vehicle at ``kmh`` [km/h] on wheels of a diameter [m]."""
    return kmh / 3.6 / (0.5 * wheel_diameter)


def with_shaft_speed(operating: Mapping[str, Any], default_diameter: float) -> Mapping[str, Any]:
    """Return the values of the group ``operating`` with a speed in km/h replaced by the shaft's.

    Values that are not numbers within their ranges are left for the fields to refuse.
    """
    kmh, diameter = operating.get("speed_kmh"), operating.get("wheel_diameter", default_diameter)
    if not (isinstance(kmh, float) and 0.0 < abs(kmh) <= FASTEST_KMH and isinstance(diameter, float) and diameter > 0.0):
        return operating
    return {**operating, "speed": shaft_speed(kmh, diameter), "speed_kmh": 0.0}


def replaced(changes: Mapping[str, Any], wheel_diameter: float, source: str) -> dict[str, Any]:
    """Return changes with dotted keys, their speed in km/h replaced by the shaft's.

    Raises:
        Refusal: both speeds are given, or the speed in km/h is not a number within its range.
    """
    if SPEED_KMH not in changes:
        return dict(changes)
    kmh = changes[SPEED_KMH]
    if SPEED in changes:
        raise Refusal(f"{source}: it sets {SPEED} and {SPEED_KMH}; give one of them")
    if isinstance(kmh, bool) or not isinstance(kmh, (int, float)) or not abs(kmh) <= FASTEST_KMH:
        raise Refusal(f"{source}: {SPEED_KMH} = {kmh!r} km/h is not a number within {-FASTEST_KMH:g} .. {FASTEST_KMH:g} km/h")
    others = {key: value for key, value in changes.items() if key != SPEED_KMH}
    return {SPEED: shaft_speed(float(kmh), wheel_diameter), **others}


def without_replaced(given: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a file that still count once ``changes`` are on top of them: a speed in rad/s replaces one in km/h."""
    return {key: value for key, value in given.items() if key != SPEED_KMH or SPEED not in changes}

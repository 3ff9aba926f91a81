"""The two parameters for one speed: of the shaft in rad/s, and of a vehicle in km/h whose wheels turn with it.

``operating.speed_kmh`` is another way to write ``operating.speed``; a validated configuration contains the shaft's speed, and 0 km/h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from dcrb_ros.schema.refusal import Refusal

SPEED, SPEED_KMH = "operating.speed", "operating.speed_kmh"
FASTEST_KMH = 1000.0
"""Largest speed of a vehicle [km/h]."""


OTHER_UNITS = {"rpm": math.pi / 30.0, "hz": 2.0 * math.pi}
"""Units in which speeds are often given [rad/s]."""


def in_other_unit(key: str, value: object) -> str:
    """Return how to give a speed that an unknown key such as ``rpm`` or ``speed_hz`` names in another unit, or an empty string."""
    unit = key.lower().rpartition(".")[2].removeprefix("speed_")
    if unit not in OTHER_UNITS:
        return ""
    number = float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else 1.0
    return f"; speeds are in rad/s: {number:g} {unit.replace('hz', 'Hz')} is {SPEED}={number * OTHER_UNITS[unit]:.6g}"


def shaft_speed(kmh: float, wheel_diameter: float) -> float:
    """Return the shaft's speed [rad/s] of a vehicle at ``kmh`` [km/h] on wheels of a diameter [m]."""
    return kmh / 3.6 / (0.5 * wheel_diameter)


def with_shaft_speed(operating: Mapping[str, Any], default_diameter: float) -> Mapping[str, Any]:
    """Return the values of the group ``operating`` with a speed in km/h replaced by the shaft's.

    Values that are not numbers within their ranges are left for the fields to refuse.

    Raises:
        ValueError: both speeds are given.
    """
    speed = _converted(operating.get("speed_kmh"), operating.get("wheel_diameter", default_diameter))
    if speed is None:
        return operating
    if "speed" in operating:
        raise ValueError(
            f"{SPEED} = {operating['speed']} rad/s and {SPEED_KMH} = {operating['speed_kmh']} km/h are two forms of one parameter: "
            "give one of them"
        )
    return {**operating, "speed": speed, "speed_kmh": 0.0}


def _converted(kmh: Any, wheel_diameter: Any) -> float | None:
    """Return the shaft's speed [rad/s], or None without a speed in km/h, or with values that are not numbers within their ranges."""
    if not all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in (kmh, wheel_diameter)):
        return None
    return shaft_speed(kmh, wheel_diameter) if 0.0 < abs(kmh) <= FASTEST_KMH and wheel_diameter > 0.0 else None


def layered(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with dotted keys after changes ``above`` them: a speed in one form replaces one in the other."""
    replaced_form = SPEED if above.get(SPEED_KMH) else SPEED_KMH if SPEED in above else ""
    return {**{key: value for key, value in below.items() if key != replaced_form}, **above}


def with_one_speed(parameters: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return all parameters of a configuration after ``changes`` that are among them, the speed in the form that was changed last."""
    if SPEED in changes:
        return {**parameters, SPEED_KMH: changes.get(SPEED_KMH, 0.0)}
    speed = _converted(parameters.get(SPEED_KMH), parameters.get("operating.wheel_diameter"))
    return dict(parameters) if speed is None else {**parameters, SPEED: speed, SPEED_KMH: 0.0}


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

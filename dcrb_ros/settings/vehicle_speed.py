"""The two parameters for one speed: of the shaft in rad/s, and of a vehicle in km/h whose wheels turn with it.

``operating.speed_kmh`` is another way to write ``operating.speed``; a validated configuration contains the shaft's speed, and 0 km/h.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SPEED, SPEED_KMH, WHEEL_DIAMETER = "operating.speed", "operating.speed_kmh", "operating.wheel_diameter"
FASTEST_KMH = 1000.0
"""Largest speed of a vehicle [km/h]."""
LARGEST_WHEEL = 5.0
"""Largest diameter of a wheel [m]."""


def shaft_speed(kmh: float, wheel_diameter: float) -> float:
    """Return the shaft's speed [rad/s] of a vehicle at ``kmh`` [km/h] on wheels of a diameter [m]."""
    return kmh / 3.6 / (0.5 * wheel_diameter)


def with_shaft_speed(operating: Mapping[str, Any], default_diameter: float) -> Mapping[str, Any]:
    """Return the values of the group ``operating`` with a speed in km/h replaced by the shaft's.

    Values that are not numbers within their ranges are left for the fields to refuse.

    Raises:
        ValueError: both speeds are given.
    """
    speed = converted(operating.get("speed_kmh"), operating.get("wheel_diameter", default_diameter))
    if speed is None:
        return operating
    if "speed" in operating:
        raise ValueError(
            f"{SPEED} = {operating['speed']} rad/s and {SPEED_KMH} = {operating['speed_kmh']} km/h are two forms of one parameter: "
            "give one of them"
        )
    return {**operating, "speed": speed, "speed_kmh": 0.0}


def converted(kmh: Any, wheel_diameter: Any) -> float | None:
    """Return the shaft's speed [rad/s], or None without a speed in km/h, or with values that are not numbers within their ranges."""
    if not all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in (kmh, wheel_diameter)):
        return None
    return shaft_speed(kmh, wheel_diameter) if 0.0 < abs(kmh) <= FASTEST_KMH and 0.0 < wheel_diameter <= LARGEST_WHEEL else None

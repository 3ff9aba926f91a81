"""Loads of the boxes that change slowly: weight, curve, wind and brakes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.parameter_field import field_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import GRAVITY, JOURNAL_DISTANCE, WHEEL_DISTANCE, Journey, Vehicle

BETWEEN_AXLES = 1800.0
"""Load that braking at 1 m/s^2 moves from the trailing to the leading axle, for each box [N] (an assumption)."""


def unbalanced(speed: float, curvature: float, cant: float) -> float:
    """Return the unbalanced acceleration of a curve, v^2 / R - g h / 1.5 m, positive to the right [m/s^2]."""
    outwards = speed**2 * curvature
    return outwards - _sign(curvature) * GRAVITY * cant / WHEEL_DISTANCE


def _sign(value: float) -> float:
    return float((value > 0.0) - (value < 0.0))


def quasi_static(vehicle: Vehicle, speed: float, curvature: float, cant: float, wind: float, brake: float) -> Floats:
    """Return the force on the inner ring of each box in X and Y, shape (boxes, 2) [N].

    A curve to the left loads the right side by (m_b h_b / 2 + m_f h_f) a_q / 4 b, wind to the left the left side by W h_w / 8 b, with half
    the distance of the boxes b. Brakes load each box by (m_b / 2 + m_f) a / 4 along the track, and move load to the leading axle.
    """
    body, frame, half = vehicle.body, vehicle.frame, 0.5 * JOURNAL_DISTANCE
    curve = (0.5 * body.mass * body.height + frame.mass * frame.height) * unbalanced(speed, curvature, cant) / (4.0 * half)
    gust = wind * body.wind_height / (8.0 * half)
    nod = body.mass * body.height / (4.0 * body.bogies) * brake
    middle = sum(axle.x for axle in vehicle.axles) / len(vehicle.axles)
    loads = np.empty((len(vehicle.boxes), 2))
    for j, box in enumerate(vehicle.boxes):
        lead = _sign(vehicle.axles[box.axle].x - middle)
        downwards = vehicle.static_load + box.side * (gust - curve) + nod + lead * BETWEEN_AXLES * brake
        # The bearing's X points backwards: inertia presses the body forward, against -X.
        loads[j] = -(0.5 * body.mass + frame.mass) * brake / 4.0, -downwards
    return loads


def check_loads(vehicle: Vehicle, commands: Mapping[str, float], where: str = "", end: str = "") -> Floats:
    """Return `quasi_static` of commands by their names, the speed in km/h; ``where`` begins and ``end`` completes a refusal.

    Raises:
        Refusal: the commands leave a box without load.
    """
    speed, others = commands["speed_kmh"], {name: commands[name] for name in ("curvature", "cant", "wind", "brake")}
    loads = quasi_static(vehicle, speed / 3.6, **others)
    box = int(np.argmax(loads[:, 1]))
    if loads[box, 1] >= 0.0:
        units = {name: field_of(name, Journey.model_fields[name]).unit for name, value in others.items() if value}
        causes = ", ".join(f"{name} = {others[name]:g} {unit}" for name, unit in units.items())
        # Straight ahead, the loads do not depend on the speed.
        remedy = " or ".join(f"the {name}" for name in (["speed"] if others["curvature"] else []) + [*units])
        raise Refusal(
            f"{where}speed_kmh = {speed:g} km/h with {causes} loads {vehicle.boxes[box].name} with {-1e-3 * loads[box, 1]:.4g} kN, and the "
            f"model needs more than 0 kN: lower {remedy}{end}"
        )
    return loads

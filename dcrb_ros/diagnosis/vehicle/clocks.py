"""Which of two boxes has a wrong clock.

Both boxes of a wheelset count the turns of one shaft, which gives the difference of their clocks. The rail says which one is wrong: the
waveforms of a side follow each other after L / v, and if one of the two clocks is fast, that lag drifts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.vehicle.causes import SAME_RAIL, lag_between, wheelsets
from dcrb_ros.diagnosis.vehicle.contact import Contact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status

AGREED = 0.4
"""Departure of a drift from that of a right or of a wrong clock up to which it is one, relative to the difference of the clocks [-]."""


def clock_differences(description: VehicleDescription, contacts: Mapping[str, Contact]) -> dict[str, float]:
    """Return by how much faster the clock of the left box of each wheelset is than that of the right one [ppm].

    A fast clock takes more samples in a turn, so the shaft seems to turn more slowly.
    """
    differences = {}
    for axle in description.axles:
        left, right = (contacts.get(f"{axle.name}/{side}") for side in SIDES)
        if left is None or right is None or left.seconds != right.seconds or not abs(left.turns) > 1.0:
            continue
        difference = 1e6 * (right.shaft_frequency / left.shaft_frequency - 1.0)
        if math.isfinite(difference):
            differences[axle.name] = difference
    return differences


def drift(description: VehicleDescription, contacts: Mapping[str, Contact], side: str, tolerance: float) -> float:
    """Return by how much faster the clock of the trailing box of a side is than that of the leading one [ppm]; NaN if it is not known.

    The lags of both halves of the window are compared with those at the speeds of the halves. ``tolerance`` is the departure that is
    searched [s].
    """
    first = contacts.get(f"{wheelsets(description)[0]}/{side}")
    if first is None:
        return math.nan
    half = len(first.motion) // 2
    late = []
    for part, turns in ((slice(0, half), first.first_turns), (slice(len(first.motion) - half, None), first.turns - first.first_turns)):
        lag = lag_between(description, contacts, side, side, tolerance, part)
        if lag is None or lag.forward < SAME_RAIL:
            return math.nan
        late.append(lag.found - lag.expected * 0.5 * first.turns / turns)
    return 1e6 * (late[1] - late[0]) / (0.5 * first.seconds)


def clocks(description: VehicleDescription, contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters) -> dict[str, Status]:
    """Return the status of the sensors of each wheelset whose clocks differ: ``clock`` of the wrong one, or both undecided.

    It is decided if the clocks of the other wheelset agree, and the lag drifts on one side only.
    """
    differences = clock_differences(description, contacts)
    statuses = {}
    for axle, difference in differences.items():
        if abs(difference) < parameters.clock:
            continue
        others_agree = all(abs(other) < parameters.clock for name, other in differences.items() if name != axle)
        wrong = _wrong_side(description, contacts, axle, difference, parameters.lag_tolerance) if others_agree else ""
        for side in SIDES:
            score = abs(difference) / parameters.clock
            reason = f"the clocks of the two boxes of the wheelset differ by {abs(difference):.0f} ppm"
            if not wrong:
                statuses[f"{axle}/{side}"] = Status(UNDECIDED, f"{reason}, and one of them is wrong", 0.0, score)
            elif side == wrong:
                reason = f"{reason}, and the lag of the rail drifts on this side only"
                statuses[f"{axle}/{side}"] = Status("clock", reason, probability(score), score)
    return statuses


def _wrong_side(description: VehicleDescription, contacts: Mapping[str, Contact], axle: str, difference: float, tolerance: float) -> str:
    """Return the side of a wheelset whose clock drifts against the other wheelset; empty if the drifts do not say."""
    sign = 1.0 if axle == wheelsets(description)[1] else -1.0
    left, right = (sign * drift(description, contacts, side, tolerance) for side in SIDES)
    limit = AGREED * abs(difference)
    if abs(left - difference) <= limit and abs(right) <= limit:
        return SIDES[0]
    if abs(right + difference) <= limit and abs(left) <= limit:
        return SIDES[1]
    return ""

"""What the impacts that the boxes heard tell about track, wheels and sensors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.vehicle.contact import Contact, Impact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status

TOGETHER = 0.006
"""Time within which a joint of both rails strikes both wheels of a wheelset [s]: bending waves take 1 ms across the axle."""
WEAKER = 3.0
"""By how much a flat must be weaker at every other box to be its wheel's [dB]; 7 to 8 dB were computed across an axle."""
SLOWEST = 1.0
"""Speed below which impacts of two wheelsets are not matched [m/s]."""
SAME_ANGLE = 0.06
"""Distance from the angle of a flat within which an impact is its own [turns]."""


class Passage(NamedTuple):
    """A kink that met a wheel of the leading and one of the trailing wheelset on one side."""

    side: str
    time: float
    """At the leading wheelset [s]."""
    lag: float
    """[s]"""


def silent_boxes(contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters) -> dict[str, float]:
    """Return how far below the median of the other boxes the level of each box is [dB], for those that do not hear the rail."""
    quiet = {}
    for name, contact in contacts.items():
        others = [other.median for key, other in contacts.items() if key != name]
        if len(others) < 2 or float(np.median(others)) <= 0.0:
            continue
        below = 10.0 * math.log10(float(np.median(others)) / max(contact.median, 1e-30))
        if below >= parameters.silence:
            quiet[name] = below
    return quiet


def flats(contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters) -> dict[str, Status]:
    """Return the status of each wheel.

    The box above a flat hears it most. If another box hears it nearly as loud, the wheel is undecided between them.
    """
    statuses = {name: Status("healthy", f"no angle of the wheel is {parameters.flat:g} dB above the others") for name in contacts}
    struck = {name: contact for name, contact in contacts.items() if contact.level >= parameters.flat}
    if not struck:
        return statuses
    for name, contact in struck.items():
        rivals = {other: contact.peak / max(heard.peak, 1e-30) for other, heard in struck.items() if other != name}
        rival = min(rivals, key=lambda other: rivals[other], default="")
        ahead = 10.0 * math.log10(max(rivals[rival], 1e-30)) if rival else math.inf
        score = contact.level - parameters.flat
        heard_at = f"one angle of the wheel is {contact.level:.1f} dB above the others"
        if ahead >= WEAKER:
            than = f", {ahead:.1f} dB more than at {rival}" if rival else ""
            statuses[name] = Status("flat", f"{heard_at}{than}", probability(score), score)
        elif ahead > -WEAKER:
            statuses[name] = Status(UNDECIDED, f"{heard_at}, but {rival} hears it within {WEAKER:g} dB", 0.0, score)
        else:
            statuses[name] = Status("healthy", f"{heard_at}, {-ahead:.1f} dB less than at {rival}")
    return statuses


class TrackHearing(NamedTuple):
    """What is known about the track, and about the order of the wheelsets."""

    status: Status
    passages: Sequence[Passage]
    reversed_sides: tuple[str, ...]
    """Sides on which the trailing wheelset met the kinks first."""


def track(
    description: VehicleDescription, contacts: Mapping[str, Contact], wheels: Mapping[str, Status], parameters: VehicleDetectorParameters
) -> TrackHearing:
    """Return the status of the track from impacts that meet one wheelset after the other, at no fixed angle."""
    ahead, behind = _wheelsets(description)
    passages: list[Passage] = []
    backwards: list[Passage] = []
    if ahead and behind:
        distance = description.axle(ahead).x - description.axle(behind).x
        for side in SIDES:
            first, second = f"{ahead}/{side}", f"{behind}/{side}"
            if first not in contacts or second not in contacts:
                continue
            speed = 2.0 * math.pi * contacts[first].shaft_frequency * description.axle(ahead).wheel_radius
            if not math.isfinite(speed) or abs(speed) < SLOWEST:
                continue
            lag = distance / speed
            leading = _not_at_a_flat(contacts[first], wheels.get(first))
            trailing = _not_at_a_flat(contacts[second], wheels.get(second))
            passages += _matched(side, leading, trailing, lag, parameters.lag_tolerance)
            backwards += _matched(side, leading, trailing, -lag, parameters.lag_tolerance)
    reversed_sides = tuple(
        side for side in SIDES if _count(backwards, side) > max(1, _count(passages, side)) and not _count(passages, side)
    )
    return TrackHearing(_track_status(passages), passages, reversed_sides)


def _wheelsets(description: VehicleDescription) -> tuple[str, str]:
    """Return the names of the leading and the trailing wheelset; empty without two."""
    ordered = sorted(description.axles, key=lambda axle: -axle.x)
    return (ordered[0].name, ordered[-1].name) if len(ordered) > 1 else ("", "")


def _not_at_a_flat(contact: Contact, wheel: Status | None) -> Sequence[Impact]:
    """Return the impacts of a box, none if its wheel has a flat, which strikes in every turn."""
    return contact.impacts if wheel is None or wheel.verdict == "healthy" else ()


def _matched(side: str, leading: Sequence[Impact], trailing: Sequence[Impact], lag: float, tolerance: float) -> list[Passage]:
    """Return the impacts of the leading wheelset that the trailing one repeats after a lag [s]."""
    passages = []
    for impact in leading:
        near = [other.time - impact.time for other in trailing if abs(other.time - impact.time - lag) <= tolerance]
        if near:
            passages.append(Passage(side, impact.time, min(near, key=lambda value: abs(value - lag))))
    return passages


def _count(passages: Iterable[Passage], side: str) -> int:
    return sum(passage.side == side for passage in passages)


def _track_status(passages: Sequence[Passage]) -> Status:
    left, right = ([passage for passage in passages if passage.side == side] for side in SIDES)
    both = [passage for passage in left if any(abs(passage.time - other.time) <= TOGETHER for other in right)]
    if not passages:
        return Status("healthy", "no impact meets one wheelset after the other")
    lag = float(np.median([passage.lag for passage in passages]))
    lagged = f"repeated {lag * 1e3:.1f} ms later by the other wheelset"
    if both:
        return Status("joint", f"{len(both)} impacts on both rails at once, {lagged}", probability(3.0 * len(both)), 3.0 * len(both))
    sides = [side for side, group in zip(SIDES, (left, right), strict=True) if group]
    score = 3.0 * len(passages)
    return Status("crossing", f"{len(passages)} impacts on the {' and the '.join(sides)} rail, {lagged}", probability(score), score)


def clock_differences(description: VehicleDescription, contacts: Mapping[str, Contact]) -> dict[str, float]:
    """Return by how much faster the clock of the left box of each wheelset is than that of the right one [ppm].

    Both count the turns of one shaft. A fast clock takes more samples in a turn, so the shaft seems to turn more slowly.
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

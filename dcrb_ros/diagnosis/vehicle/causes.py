"""What the impacts that the boxes measured show of track, wheels and sensors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.vehicle.comparison import UNOPPOSED, unopposed
from dcrb_ros.diagnosis.vehicle.contact import FEWEST_TURNS, Contact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status

OTHERS = 2
"""Other boxes with which the level of a box is compared at least [-]."""
TOGETHER = 0.006
"""Time within which a joint of both rails strikes both wheels of a wheelset [s]: bending waves take 1 ms across the axle."""
WEAKER = 3.0
"""By how much a flat must be weaker at other boxes with an angle above the level [dB]; 7 to 8 dB were computed across an axle."""
SLOWEST = 1.0
"""Speed below which impacts of two wheelsets are not matched [m/s]."""
LONG_WAVES = (20.0, 150.0)
"""Frequencies in which waveforms of two wheelsets are compared [Hz]."""
SAME_RAIL = 0.5
"""Correlation from which two boxes follow the same rail [-]; 0.93 to 0.95 were computed, at most 0.11 at the wrong lag."""
ONE_RAIL = 6.0
"""Difference of the sides from which a kink is on one rail [dB]."""
TURNS = 3.0
"""Turns before and after an impact in which two others at its angle show that a wheel makes it [-]: a joint makes two."""


def silent_boxes(contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters) -> dict[str, float]:
    """Return how far below the quietest of the other boxes the level of a box is [dB], for those that do not measure the rail.

    Three boxes are needed: of two, the louder one may as well be wrong. Boxes without a signal do not count.
    """
    below = {}
    for name, contact in contacts.items():
        others = [other.median for key, other in contacts.items() if key != name and other.median > 0.0]
        if len(others) >= OTHERS:
            below[name] = 10.0 * math.log10(min(others) / max(contact.median, 1e-30))
    return {name: level for name, level in below.items() if level >= parameters.silence}


def flats(contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters, partners: Mapping[str, str]) -> dict[str, Status]:
    """Return the status of each wheel; it is ``waiting`` where too few turns are known.

    ``partners`` are the other boxes of the wheelsets. If that of a box is not judged, a flat may be that of its wheel.
    The box above a flat has it largest. If another box has one angle above the level, too, and nearly as large, the wheel is undecided
    between them. Boxes below the level do not count: the roughness of a round wheel may be as large at one angle.
    """
    no_flat, too_short = (
        f"no angle of the wheel is {parameters.flat:g} dB above the others",
        f"a verdict needs {FEWEST_TURNS} turns of its angle",
    )
    statuses = {name: Status("healthy", no_flat) if contact.peak else Status("waiting", too_short) for name, contact in contacts.items()}
    struck = {name: contact for name, contact in contacts.items() if contact.level >= parameters.flat}
    alone = unopposed({name for name, contact in contacts.items() if contact.peak}, partners)
    for name, contact in struck.items():
        rivals = {other: contact.peak / max(measured.peak, 1e-30) for other, measured in struck.items() if other != name}
        rival = min(rivals, key=lambda other: rivals[other], default="")
        ahead = 10.0 * math.log10(max(rivals[rival], 1e-30)) if rival else math.inf
        score = contact.level - parameters.flat
        at_one_angle = f"one angle of the wheel is {contact.level:.1f} dB above the others"
        if ahead >= WEAKER and name in alone:
            statuses[name] = Status(UNDECIDED, f"{at_one_angle}, but {UNOPPOSED}", 0.0, score)
        elif ahead >= WEAKER:
            than = f", {ahead:.1f} dB more than at {rival}" if rival else ""
            statuses[name] = Status("flat", f"{at_one_angle}{than}", probability(score), score)
        elif ahead > -WEAKER:
            statuses[name] = Status(UNDECIDED, f"{at_one_angle}, but {rival} has it within {WEAKER:g} dB", 0.0, score)
        else:
            statuses[name] = Status("healthy", f"{at_one_angle}, {-ahead:.1f} dB less than at {rival}")
    return statuses


class Lag(NamedTuple):
    """How the waveform of the trailing box of a side follows that of the leading one."""

    expected: float
    """Distance of the wheelsets over the speed [s]."""
    found: float
    """Lag of the largest correlation near the expected one [s]."""
    forward: float
    """Correlation there [-]."""
    backward: float
    """Largest correlation near the lag of the other sign [-]."""


def lags(description: VehicleDescription, contacts: Mapping[str, Contact], tolerance: float) -> dict[str, Lag]:
    """Return the lag of each side whose boxes measure the rail; ``tolerance`` is the departure that is searched [s]."""
    found = {side: lag_between(description, contacts, side, side, tolerance) for side in SIDES}
    return {side: lag for side, lag in found.items() if lag is not None}


def lag_between(
    description: VehicleDescription,
    contacts: Mapping[str, Contact],
    first_side: str,
    second_side: str,
    tolerance: float,
    part: slice = slice(None),
) -> Lag | None:
    """Return the lag of the trailing box of a second side behind the leading one of a first side, in a ``part`` of their waveforms.

    None if one of them does not measure the rail, the vehicle hardly moves or the part is too short; ``tolerance`` is the departure that is
    searched [s].
    """
    ahead, behind = wheelsets(description)
    first, second = contacts.get(f"{ahead}/{first_side}"), contacts.get(f"{behind}/{second_side}")
    expected = expected_lag(description, contacts, first_side)
    if first is None or second is None or expected is None or len(first.motion) != len(second.motion):
        return None
    return correlated_lag(first.motion[part], second.motion[part], first.motion_rate, expected, tolerance)


def correlated_lag(first: Floats, second: Floats, rate: float, expected: float, tolerance: float) -> Lag | None:
    """Return the lag of the second waveform behind the first, both at a ``rate`` [Hz]; None if the signals are too short for it.

    The correlation is that of `LONG_WAVES`, in which the irregularity of the rail is larger than the roughness of the wheels.
    """
    shift, reach = round(abs(expected) * rate), max(1, round(tolerance * rate))
    if shift <= reach or len(first) < 4 * (shift + reach):
        return None
    length = 2 * len(first)
    frequency = np.fft.rfftfreq(length, 1.0 / rate)
    kept = (frequency >= LONG_WAVES[0]) & (frequency <= LONG_WAVES[1])
    spectra = [np.where(kept, np.fft.rfft(values - values.mean(), length), 0.0) for values in (first, second)]
    energies = [float(np.square(np.fft.irfft(spectrum, length)).sum()) for spectrum in spectra]
    if min(energies) <= 0.0:
        return None
    correlation = np.fft.irfft(np.conj(spectra[0]) * spectra[1], length) / np.sqrt(energies[0] * energies[1])
    direction = 1 if expected > 0.0 else -1
    steps = np.arange(shift - reach, shift + reach + 1) * direction
    forward, backward = correlation[steps % length], correlation[-steps % length]
    best = int(np.argmax(forward))
    before, here, after = (float(correlation[(steps[best] + step * direction) % length]) for step in (-1, 0, 1))
    offset = 0.5 * (before - after) / min(before - 2.0 * here + after, -1e-12)
    return Lag(expected, float(steps[best] + direction * np.clip(offset, -0.5, 0.5)) / rate, here, float(backward.max()))


def backward_sides(sides: Mapping[str, Lag]) -> tuple[str, ...]:
    """Return the sides on which the trailing wheelset meets the rail first: its sensors are swapped if another side is forward."""
    return tuple(side for side, lag in sides.items() if lag.backward >= SAME_RAIL and lag.forward < 0.5 * lag.backward)


def crossed_rails(description: VehicleDescription, contacts: Mapping[str, Contact], tolerance: float) -> bool:
    """Return whether the trailing boxes follow those across: left and right sensors of one wheelset are swapped.

    The signals do not say of which one. With both wheelsets swapped, they are those of the same vehicle seen in a mirror.
    """
    found = {}
    for first_side, second_side in itertools.product(SIDES, SIDES):
        lag = lag_between(description, contacts, first_side, second_side, tolerance)
        if lag is None:
            return False
        found[first_side == second_side, first_side] = lag.forward
    across, along = min(found[False, side] for side in SIDES), max(found[True, side] for side in SIDES)
    return across >= SAME_RAIL and along < 0.5 * across


class Kinks(NamedTuple):
    """Impacts that meet one wheelset after the other."""

    first: Floats
    """Times at which they meet the first wheelset [s]."""
    lags: Floats
    """Times from there to each wheelset, in order [s]."""
    louder: Floats
    """By how much louder each is on the left than on the right, over the noise of the rail [dB]; NaN if one side is not measured."""

    @property
    def times(self) -> Floats:
        """Times at which they meet any wheelset, in order [s]."""
        return np.unique(np.add.outer(self.first, self.lags))


def kinks_of(
    description: VehicleDescription, contacts: Mapping[str, Contact], wheels: Mapping[str, Status], tolerance: float
) -> Kinks | None:
    """Return the impacts that meet one wheelset after the other; None if the vehicle hardly moves, or without a shaft angle.

    Boxes of the first and the last wheelset measure each kink. Which of them has more of it depends on the structure, so that times count
    only, with a ``tolerance`` [s]. Impacts at a fixed angle of a wheelset are left out, and boxes above a flat, because it strikes in every
    turn. On a side without an impact, one that is too faint to be counted may be hidden.
    """
    expected = next((lag for side in SIDES if (lag := expected_lag(description, contacts, side)) is not None), None)
    if expected is None:
        return None
    places = np.array([axle.x for axle in description.axles])
    ahead = places.max() - places if expected > 0.0 else places - places.min()
    lags = np.sort(abs(expected) * (ahead / np.ptp(places)))
    measured = {name: contact for name, contact in contacts.items() if name not in wheels or wheels[name].verdict in ("healthy", "waiting")}
    times = _together([impact.time for contact in measured.values() for impact in contact.impacts])
    of_wheels = _at_fixed_angles(contacts, tolerance)
    times = np.array([time for time in times if not np.any(np.abs(of_wheels - time) <= tolerance)])
    first = np.array([time for time in times if np.any(np.abs(times - time - lags[-1]) <= tolerance)])
    louder = [_loudness(measured, time, SIDES[0]) - _loudness(measured, time, SIDES[1]) for time in first]
    return Kinks(first, lags, np.array(louder))


def track(kinks: Kinks | None) -> Status:
    """Return the status of the track from the impacts that meet one wheelset after the other."""
    if kinks is None:
        return Status("waiting", "two wheelsets with a shaft angle are needed")
    if not len(kinks.first):
        return Status("healthy", "no impact meets one wheelset after the other")
    difference, score = float(np.median(kinks.louder)), 3.0 * len(kinks.first)
    again = f"{len(kinks.first)} impact{'s' * (len(kinks.first) > 1)} that the other wheelset repeats {kinks.lags[-1] * 1e3:.1f} ms later"
    if math.isnan(difference):
        return Status("joint", f"{again}; only one side is measured", probability(score), score)
    if abs(difference) < ONE_RAIL:
        return Status("joint", f"{again}, on both sides alike", probability(score), score)
    side = SIDES[0] if difference > 0.0 else SIDES[1]
    return Status("crossing", f"{again}, {abs(difference):.1f} dB more on the {side}", probability(score), score)


def wheelsets(description: VehicleDescription) -> tuple[str, str]:
    """Return the names of the leading and the trailing wheelset; empty without two."""
    ordered = sorted(description.axles, key=lambda axle: -axle.x)
    return (ordered[0].name, ordered[-1].name) if len(ordered) > 1 else ("", "")


def expected_lag(description: VehicleDescription, contacts: Mapping[str, Contact], side: str) -> float | None:
    """Return the distance of the wheelsets over the speed [s], negative backwards; None if the vehicle hardly moves."""
    ahead, behind = wheelsets(description)
    contact = contacts.get(f"{ahead}/{side}")
    if contact is None:
        return None
    speed = 2.0 * math.pi * contact.shaft_frequency * description.axle(ahead).wheel_radius
    if not math.isfinite(speed) or abs(speed) < SLOWEST:
        return None
    return (description.axle(ahead).x - description.axle(behind).x) / speed


def _together(times: Iterable[float]) -> Floats:
    """Return times in order, those of impacts within `TOGETHER` as one."""
    distinct: list[float] = []
    for time in sorted(times):
        if not distinct or time - distinct[-1] > TOGETHER:
            distinct.append(time)
    return np.asarray(distinct, np.float64)


def _at_fixed_angles(contacts: Mapping[str, Contact], tolerance: float) -> Floats:
    """Return the times of impacts that a box measured at a fixed angle of any wheelset [s]; ``tolerance`` is that of their distance [s]."""
    found = []
    for contact, frequency in itertools.product(contacts.values(), {abs(contact.shaft_frequency) for contact in contacts.values()}):
        times = np.array([impact.time for impact in contact.impacts])
        turns = frequency * np.abs(np.subtract.outer(times, times))
        whole = np.rint(turns)
        alike = (np.abs(turns - whole) <= tolerance * frequency) & (whole >= 1.0) & (whole <= TURNS)
        found.append(times[alike.sum(axis=1) >= 2])
    return np.concatenate(found)


def _loudness(measured: Mapping[str, Contact], time: float, side: str) -> float:
    """Return the loudness of an impact at a time in the boxes of a side [dB].

    Without an impact it is the largest that may be hidden, and NaN without a box.
    """
    of_side = [contact for name, contact in measured.items() if name.endswith(side)]
    found = [impact.loudness for contact in of_side for impact in contact.impacts if abs(impact.time - time) <= TOGETHER]
    return max(found) if found else min((contact.faintest for contact in of_side), default=math.nan)

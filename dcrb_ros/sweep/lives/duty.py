"""The duty of a vehicle: sections of constant speed and load, from a line of stations or from a spectrum."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

from dcrb_ros.prognosis.rating_life import equivalent_load
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.vehicle_speed import shaft_speed
from dcrb_ros.sweep.lives.recipe import Braking, Level, Station


class Section(NamedTuple):
    """A part of the duty at one load, with a time at constant speed."""

    name: str
    speed: float
    """Constant speed of the shaft [rad/s]."""
    load: float
    """Load on the bearing [N]."""
    steady: float
    """Time at constant speed [h]."""
    total: float
    """Time with accelerating, braking and standing [h]."""
    revolutions: float
    """Revolutions of the shaft, with those while accelerating and braking [-]."""


class Duty(NamedTuple):
    """A duty that a vehicle repeats until its bearings fail."""

    sections: tuple[Section, ...]

    @property
    def hours(self) -> float:
        """Time of one repetition [h]."""
        return sum(section.total for section in self.sections)

    @property
    def revolutions_per_hour(self) -> float:
        """Mean revolutions of the shaft in an operating hour, standstill included [1/h]."""
        return sum(section.revolutions for section in self.sections) / self.hours

    @property
    def load(self) -> float:
        """Equivalent load of the rating life (ISO 281) [N]."""
        return equivalent_load([section.load for section in self.sections], [section.revolutions for section in self.sections])

    def inspected(self, name: str, seconds: float, source: str) -> tuple[Section, ...]:
        """Return the sections on which an inspection of a duration [s] fits into the time at constant speed.

        Raises:
            Refusal: there is none, or not the one of a given name.
        """
        known = [section.name for section in self.sections if section.speed > 0.0]
        if name and name not in known:
            raise Refusal(f"{source}: inspection.section = '{name}' is no section with a moving vehicle: the duty has {', '.join(known)}")
        chosen = [section for section in self.sections if section.speed > 0.0 and name in ("", section.name)]
        long = tuple(section for section in chosen if 3600.0 * section.steady >= seconds)
        if not long:
            longest = max((3600.0 * section.steady for section in chosen), default=0.0)
            raise Refusal(
                f"{source}: an inspection of {seconds:g} s is longer than every stretch at constant speed, {longest:.3g} s at most: "
                "shorten duration and settle, or lengthen the stretches"
            )
        return long


def duty_of_line(stations: Sequence[Station], braking: Braking, wheel_diameter: float, source: str) -> Duty:
    """Return the duty of a run from the first station to the last one on wheels of a diameter [m].

    Between two stations the train accelerates, keeps the permitted speed, and brakes; on a stretch that is too short for the permitted
    speed v it reaches v = sqrt(2 s / (1/a + 1/b)) and brakes at once.

    Raises:
        Refusal: fewer than two stations, a stretch without length, permitted speed or name, or a dwell at the last station.
    """
    if len(stations) < 2:
        raise Refusal(f"{source}: line.stations has {len(stations)} station(s): give at least two, or a spectrum")
    last = stations[-1]
    if "dwell" in last.model_fields_set and last.dwell:
        raise Refusal(
            f"{source}: line.stations: the line ends at {last.name}, so its dwell of {last.dwell:g} s has no effect: leave it out, or add "
            f"it to that of {stations[0].name}, where the next run begins"
        )
    sections = []
    for station, following in itertools.pairwise(stations):
        name, distance = f"{station.name} - {following.name}", 1e3 * abs(following.km - station.km)
        if not (station.name and following.name):
            raise Refusal(f"{source}: line.stations: a station at {station.km:g} or {following.km:g} km has no name: give one")
        if not distance > 0.0 or not station.speed_kmh > 0.0:
            raise Refusal(
                f"{source}: line.stations: {name} is {distance / 1e3:g} km long at {station.speed_kmh:g} km/h, so no train reaches its "
                "end: give both above 0"
            )
        ramps = 1.0 / braking.acceleration + 1.0 / braking.braking
        fastest = min(station.speed_kmh / 3.6, math.sqrt(2.0 * distance / ramps))
        steady = max(distance / fastest - 0.5 * fastest * ramps, 0.0)
        total = steady + fastest * ramps + station.dwell
        turns = distance / (math.pi * wheel_diameter)
        speed = shaft_speed(3.6 * fastest, wheel_diameter)
        sections.append(Section(name, speed, station.load, steady / 3600.0, total / 3600.0, turns))
    return Duty(tuple(sections))


def duty_of_spectrum(levels: Sequence[Level], wheel_diameter: float, source: str) -> Duty:
    """Return the duty of a spectrum of speeds and loads on wheels of a diameter [m], as one hour.

    Raises:
        Refusal: no levels, shares that do not add up to 1, or no level with a moving vehicle.
    """
    if not levels:
        raise Refusal(f"{source}: the spectrum is empty, so no life ends: give at least one level with share, speed_kmh and load")
    total = sum(level.share for level in levels)
    if abs(total - 1.0) > 1e-6:
        raise Refusal(f"{source}: the shares of the spectrum add up to {total:g}, but must add up to 1: give shares of the operating hours")
    if not any(level.share * level.speed_kmh > 0.0 for level in levels):
        raise Refusal(f"{source}: the vehicle of the spectrum never moves, so no life ends: give a level with share and speed_kmh above 0")
    unnamed = next((level for level in levels if not level.name), None)
    if unnamed is not None:
        raise Refusal(f"{source}: spectrum: the level at {unnamed.speed_kmh:g} km/h has no name: give one")
    sections = []
    for level in levels:
        speed, turns = shaft_speed(level.speed_kmh, wheel_diameter), level.share * 1e3 * level.speed_kmh / (math.pi * wheel_diameter)
        sections.append(Section(level.name, speed, level.load, level.share, level.share, turns))
    return Duty(tuple(sections))

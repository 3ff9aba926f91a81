"""The keys of a sweep of kind ``life``, group by group."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.schema.fields import Group, choice, length, quantity
from dcrb_ros.sweep.lives.growth import Growth

LIFE = "life"
"""Value of ``kind`` that makes a sweep one of lives."""
SHARE = "give a share, not per cent"


class Station(Group):
    """A station of a line, and the stretch from it to the next one."""

    name: str = choice("", "Name of the station; required")
    km: float = quantity(0.0, "km", "Place along the line", -1e5, 1e5)
    load: float = quantity(0.0, "N", "Load on the bearing up to the next station", 0.0, 1e7, remedy="give newtons, not kN")
    speed_kmh: float = quantity(0.0, "km/h", "Permitted speed up to the next station", 0.0, 1000.0)
    dwell: float = quantity(60.0, "s", "Time at the station", 0.0, 1e6)


class Braking(Group):
    """How a train changes its speed between stations."""

    acceleration: float = quantity(0.5, "m/s^2", "Acceleration from a station", 0.01, 5.0)
    braking: float = quantity(0.6, "m/s^2", "Deceleration to a station", 0.01, 5.0)


class Level(Group):
    """A level of a spectrum of speeds and loads."""

    name: str = choice("", "Name of the level; required")
    share: float = quantity(0.0, "-", "Share of the operating hours", 0.0, 1.0, remedy=SHARE)
    speed_kmh: float = quantity(0.0, "km/h", "Speed of the vehicle; 0 at standstill", 0.0, 1000.0)
    load: float = quantity(0.0, "N", "Load on the bearing", 0.0, 1e7, remedy="give newtons, not kN")


class Inspection(Group):
    """When a bearing is measured, and when it is taken out of service."""

    every: float = quantity(200.0, "h", "Operating hours from one inspection to the next", 1e-3, 1e6)
    overhaul: float = quantity(0.0, "h", "Operating hours at which a bearing leaves service, failed or not; 0 for never", 0.0, 1e7)
    section: str = choice("", "Section of the duty on which all inspections are made; empty for any, drawn by the hours at constant speed")


class Start(Group):
    """When the damage starts."""

    rating: float = quantity(0.0, "N", "Basic dynamic load rating; 0 for that of ISO 281 from the bearing's dimensions", 0.0, 1e9)
    slope: float = quantity(1.125, "-", "Weibull slope of the lives; 9/8 for line contact (Lundberg and Palmgren)", 0.3, 20.0)
    in_service: bool = choice(False, "Whether only bearings are drawn whose damage starts before the overhaul")


class Damage(Group):
    """Where the damage is, its first size, and the size at which the bearing has failed."""

    outer: float = quantity(0.5, "-", "Share of lives with damage of the outer raceway", 0.0, 1.0, remedy=SHARE)
    inner: float = quantity(0.4, "-", "Share of lives with damage of the inner raceway", 0.0, 1.0, remedy=SHARE)
    roller: float = quantity(0.1, "-", "Share of lives with damage of a roller", 0.0, 1.0, remedy=SHARE)
    first_width: float = length(0.001, "Width at the start of the damage", 1e-5, 0.02)
    last_width: float = length(0.014, "Width at which the bearing has failed", 1e-4, 0.05)
    depth: float = length(6e-5, "Depth", 1e-6, 0.001)
    aspect: float = quantity(
        3.0,
        "-",
        "Length of a spall of a raceway along the rollers over its width; at the length of a roller it spreads no further",
        0.1,
        100.0,
    )
    azimuth_deviation: float = quantity(0.35, "rad", "Standard deviation of the azimuth of outer damage from the load line", 0.0, 1.0)


class Climate(Group):
    """Temperature of the surroundings at the inspections; it needs a thermal network."""

    mean: float = quantity(10.0, "deg C", "Mean over a year", -40.0, 60.0)
    season: float = quantity(0.0, "K", "Amplitude of the course over a year, whose beginning is drawn for each bearing", 0.0, 50.0)
    day: float = quantity(0.0, "K", "Standard deviation between inspections", 0.0, 30.0)
    hours_per_year: float = quantity(5000.0, "h", "Operating hours in a year", 1.0, 8784.0)


class Numbers(Group):
    """How many bearings there are, and the seed of all draws."""

    lives: int = quantity(10, "-", "Number of bearings", 1, 1_000_000)
    seed: int = quantity(1, "-", "Seed of everything that is drawn", 0, 2**31 - 1)


@dataclass(frozen=True)
class Recipe:
    """The parameters from which the lives of a sweep are drawn, apart from the duty."""

    numbers: Numbers
    inspection: Inspection
    start: Start
    damage: Damage
    growth: Growth
    climate: Climate | None = None
    """None for ``thermal.ambient`` at every inspection."""

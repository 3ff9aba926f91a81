"""A configuration of a roller bearing from what a catalogue prints; what it does not print is estimated and said so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import yaml

from dcrb_ros.prognosis.rating_life import dynamic_load_rating
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import checked, flatten, load_configuration, nest
from dcrb_ros.settings.parameters import STEEL_DENSITY, Bearing

CLEARANCES = (
    (30.0, 20.0, 45.0),
    (40.0, 25.0, 50.0),
    (50.0, 30.0, 60.0),
    (65.0, 40.0, 70.0),
    (80.0, 40.0, 75.0),
    (100.0, 50.0, 85.0),
    (120.0, 50.0, 90.0),
    (140.0, 60.0, 105.0),
    (160.0, 70.0, 120.0),
    (180.0, 75.0, 125.0),
    (200.0, 90.0, 145.0),
    (225.0, 105.0, 165.0),
    (250.0, 110.0, 175.0),
    (280.0, 125.0, 195.0),
    (315.0, 130.0, 205.0),
    (355.0, 145.0, 225.0),
    (400.0, 190.0, 280.0),
    (450.0, 210.0, 310.0),
    (500.0, 220.0, 330.0),
)
"""Largest bore [mm], and least and largest radial internal clearance of the normal group [um]: ISO 5753-1, cylindrical roller bearings."""
WALLS = 0.43, 0.40
"""Thickness of inner and outer ring under the raceway, over the diameter of the rollers [-]: means of the series NU 2, 22 and 3."""
WIDTH_OVER_LENGTH = 1.5
"""Width of a single-row bearing over the length of its rollers [-]."""
POCKET, LAND = 1.0 / 300.0, 1.0 / 100.0
"""Clearances of pockets and land over the diameter of the rollers [-], those of the default bearing."""
LOAD_SHARE = 0.1
"""Load over the basic dynamic load rating where no load is given [-]."""
MOST_STEPS = 400
"""Steps for a sample that are tried [-]."""
IN_SERVICE = ("lubrication.", "surfaces.", "contact.", "friction.", "cage.restitution", "operating.start", "operating.speed_")
"""Beginnings of the keys that the bench `healthy` lends: grease, surfaces of an individual, damping, and how a drive runs."""
TOLERANCES = ("surfaces.roller_spread", "surfaces.single_pocket_spread", "surfaces.pocket_spread", "surfaces.pocket_clearance_spread")
"""Tolerances that shrink with the cube root of the diameter, as the grades of ISO 286 do."""
TOLERANCE_DIAMETER = 30.0
"""Diameter of the rollers for which the tolerances of `healthy` hold [mm]."""
SMALLEST_ANGLE, LARGEST_ANGLE = 1.0, 57.0
"""Range of contact angles other than zero [degrees]; the same angles in radians are below it."""
LENGTHS = (0.5, 1e4)
"""Range of all lengths [mm]; those of a catalogue in metres are below it."""
CLEARANCE_RANGE = (1.0, 1000.0)
"""Range of the radial internal clearance [um]; clearances in millimetres are below it."""
AGREEMENT = 0.02
"""Largest departure of the outer raceway from inner raceway and rollers, over the diameter of the rollers [-]."""


@dataclass(frozen=True)
class CatalogueBearing:
    """A roller bearing as a catalogue describes it; lengths in mm, None where it is not known.

    With a contact angle, raceways and rollers are measured at the middle of the rollers.
    """

    inner_raceway: float
    """Diameter F of the inner raceway [mm]."""
    rollers: int
    """Rollers in each row [-]."""
    roller_diameter: float
    """[mm]"""
    roller_length: float
    """Effective length [mm]."""
    rpm: float
    """Speed of the inner ring [1/min]."""
    outer_raceway: float | None = None
    """Diameter E of the outer raceway [mm]."""
    rows: int = 1
    bore: float | None = None
    """Diameter d [mm]."""
    outside: float | None = None
    """Diameter D [mm]."""
    width: float | None = None
    """Width B [mm]."""
    clearance: float | None = None
    """Radial internal clearance [um]; the middle of the normal group where it is not given."""
    load: float | None = None
    """Radial load [N]; a tenth of the dynamic load rating where it is not given."""
    contact_angle: float = 0.0
    """Between the line of contact and the plane of rotation, of a tapered bearing the mean of both rings [degrees]."""

    def __post_init__(self) -> None:
        """Refuse dimensions that cannot be true together.

        Raises:
            Refusal: see the message.
        """
        if self.rollers < 1 or self.rows not in (1, 2):
            raise Refusal(f"{self.rows} x {self.rollers} rollers: give 1 or 2 rows, and the rollers of one row from the catalogue")
        for name, value in self._lengths().items():
            if not LENGTHS[0] <= value <= LENGTHS[1]:
                span = f"{LENGTHS[0]:g} .. {LENGTHS[1]:g} mm"
                raise Refusal(f"{name} = {value:g} mm is outside {span}: give the length from the catalogue in millimetres")
        angle = self.contact_angle
        if angle != 0.0 and not SMALLEST_ANGLE <= angle <= LARGEST_ANGLE:
            span, usual = f"{SMALLEST_ANGLE:g} .. {LARGEST_ANGLE:g}", "tapered bearings have 10 to 30, spherical ones 6 to 15"
            if 0.0 < angle < SMALLEST_ANGLE:
                usual = f"{angle:g} rad are {math.degrees(angle):.4g}"
            raise Refusal(f"the contact angle of {angle:g} degrees is neither 0 nor within {span}: give degrees; {usual}")
        if not math.isfinite(self.rpm):
            raise Refusal(f"the speed of {self.rpm:g} rpm is not a finite number: give the speed of the inner ring")
        if self.clearance is not None and not CLEARANCE_RANGE[0] <= self.clearance <= CLEARANCE_RANGE[1]:
            span = f"{CLEARANCE_RANGE[0]:g} .. {CLEARANCE_RANGE[1]:g} um"
            raise Refusal(f"clearance = {self.clearance:g} um is outside {span}: give the radial internal clearance in micrometres")
        rows = self.rows * self.roller_length * math.cos(math.radians(self.contact_angle))
        if self.width is not None and self.width < rows:
            raise Refusal(f"width = {self.width:g} mm is below the {rows:.4g} mm of its rollers: check B and the length of the rollers")
        outer = self.inner_raceway + 2.0 * self.plane_diameter
        if self.outer_raceway is not None and abs(self.outer_raceway - outer) > AGREEMENT * self.roller_diameter:
            raise Refusal(
                f"the outer raceway of {self.outer_raceway:g} mm does not fit an inner raceway of {self.inner_raceway:g} mm and rollers of "
                f"{self.roller_diameter:g} mm, which need {outer:g} mm: check F, E and the diameter of the rollers"
            )
        order = {
            "bore": self.bore,
            "inner raceway": self.inner_raceway,
            "outer raceway": self.outer_raceway or outer,
            "outside": self.outside,
        }
        known = [(name, value) for name, value in order.items() if value is not None]
        for (name, value), (next_name, next_value) in pairwise(known):
            if not value < next_value:
                raise Refusal(f"{name} {value:g} mm is not below {next_name} {next_value:g} mm: check the diameters")

    @property
    def plane_diameter(self) -> float:
        """Diameter of the rollers in the plane of rotation, D cos(alpha) [mm]."""
        return self.roller_diameter * math.cos(math.radians(self.contact_angle))

    def _lengths(self) -> Mapping[str, float]:
        lengths = {
            "inner raceway": self.inner_raceway,
            "outer raceway": self.outer_raceway,
            "roller diameter": self.roller_diameter,
            "roller length": self.roller_length,
            "bore": self.bore,
            "outside": self.outside,
            "width": self.width,
        }
        return {name: value for name, value in lengths.items() if value is not None}


@dataclass(frozen=True)
class FilledIn:
    """A value that the catalogue does not print."""

    key: str
    value: float
    source: str
    """Where the value comes from, with its unit."""


def normal_clearance(bore: float) -> float:
    """Return the middle of the normal group of radial internal clearance for a bore [mm] in um (ISO 5753-1).

    Raises:
        Refusal: the table ends below the bore.
    """
    for largest, low, high in CLEARANCES:
        if bore <= largest:
            return 0.5 * (low + high)
    raise Refusal(f"a bore of {bore:.4g} mm is beyond the table of clearances, which ends at {CLEARANCES[-1][0]:g} mm: give the clearance")


def configuration_of(bearing: CatalogueBearing) -> tuple[dict[str, Any], list[FilledIn]]:
    """Return the parameters of a configuration by key, and those of them that were filled in.

    Rings are solid steel between their diameters, without ribs; rollers are solid steel; the cage fills the annulus between the rollers
    over a roller's diameter, as that of the default bearing does within 2 %.

    Raises:
        Refusal: no step suits the bearing, or a value is outside the range of its parameter.
    """
    diameter, length, pitch = bearing.roller_diameter, bearing.roller_length, bearing.inner_raceway + bearing.plane_diameter
    outer, angle = bearing.inner_raceway + 2.0 * bearing.plane_diameter, math.radians(bearing.contact_angle)
    bore = bearing.bore or bearing.inner_raceway - 2.0 * WALLS[0] * diameter
    outside = bearing.outside or outer + 2.0 * WALLS[1] * diameter
    width = bearing.width or bearing.rows * WIDTH_OVER_LENGTH * length
    clearance = normal_clearance(bore) if bearing.clearance is None else bearing.clearance
    roller_mass = _cylinder(diameter, length)
    cage_mass = STEEL_DENSITY * 1e-9 * math.pi * pitch * diameter * length - bearing.rollers * roller_mass
    if cage_mass <= 0.0:
        raise Refusal(
            f"{bearing.rollers} rollers of {diameter:g} mm do not fit on a pitch circle of {pitch:g} mm: give the rollers of one row, and "
            "their diameter, not their radius"
        )
    known = {
        "bearing.rows": bearing.rows,
        "bearing.rollers_per_row": bearing.rollers,
        "bearing.inner_raceway_radius": 0.5e-3 * bearing.inner_raceway,
        "bearing.roller_radius": 0.5e-3 * bearing.plane_diameter,
        "bearing.roller_length": 1e-3 * length,
        "operating.speed": bearing.rpm * math.pi / 30.0,
    }
    if angle:
        known["bearing.contact_angle"] = angle
    group = "middle of the normal group" + (" of cylindrical roller bearings" if angle else "")
    radial_gap = 0.5e-6 * clearance
    solid = f"solid steel of {STEEL_DENSITY:g} kg/m^3"
    rings = "" if bearing.bore and bearing.outside and bearing.width else f", {bore:.4g} x {outside:.4g} x {width:.4g} mm estimated"
    filled = [
        FilledIn(
            "bearing.outer_raceway_radius",
            0.5e-3 * outer + radial_gap,
            f"m; radial internal clearance {clearance:g} um" + ("" if bearing.clearance is not None else f", {group}"),
        ),
        FilledIn("bearing.pitch_radius", 0.5e-3 * pitch + 0.5 * radial_gap, "m; midway between the raceways"),
        FilledIn("bearing.inner_ring_mass", _tube(bore, bearing.inner_raceway, width), f"kg; {solid}, without ribs{rings}"),
        FilledIn("bearing.outer_ring_mass", _tube(outer, outside, width), f"kg; {solid}, without ribs{rings}"),
        FilledIn("bearing.roller_mass", roller_mass, f"kg; {solid}"),
        FilledIn("bearing.roller_inertia", 0.5 * roller_mass * (0.5e-3 * diameter) ** 2, "kg m^2; mass * radius^2 / 2"),
        FilledIn("bearing.cage_mass", cage_mass, "kg; steel between the rollers; a cage of brass has 1.1, of polyamide 0.15 of it"),
        FilledIn("bearing.cage_inertia", cage_mass * (0.5e-3 * pitch) ** 2, "kg m^2; mass * pitch_radius^2"),
        FilledIn("cage.pocket_clearance", max(1e-5, 1e-3 * POCKET * diameter), "m; in proportion to the default bearing"),
        FilledIn("cage.land_clearance", max(1e-5, 1e-3 * LAND * diameter), "m; in proportion to the default bearing"),
    ]
    if bearing.load is None:
        geometry = Bearing.model_construct(
            rows=bearing.rows,
            rollers_per_row=bearing.rollers,
            roller_length=1e-3 * length,
            roller_radius=0.5e-3 * bearing.plane_diameter,
            pitch_radius=0.5e-3 * pitch,
            contact_angle=angle,
        )
        rating = dynamic_load_rating(geometry)
        source = f"N; a tenth of the load rating of {rating / 1e3:.3g} kN (ISO 281)"
        filled.append(FilledIn("operating.load", _rounded(LOAD_SHARE * rating), source))
    else:
        known["operating.load"] = bearing.load
    parameters = known | {entry.key: _rounded(entry.value) for entry in filled}
    parameters |= {key: value for key, value in _in_service(diameter).items() if key not in parameters}
    step = _longest_step(parameters)
    filled.append(FilledIn("simulation.step", step, "s; the longest that suits the modes of rollers and cage"))
    return parameters | {"simulation.step": step}, filled


def _in_service(diameter: float) -> dict[str, Any]:
    """Return what the bench `healthy` lends to a bearing with rollers of some diameter [mm]."""
    healthy, default = flatten(load_configuration("healthy").model_dump()), flatten(Configuration().model_dump())
    lent = {key: value for key, value in healthy.items() if key.startswith(IN_SERVICE)}
    grade = min(1.0, (diameter / TOLERANCE_DIAMETER) ** (1.0 / 3.0))
    lent |= {key: _rounded(grade * lent[key]) for key in TOLERANCES}
    return {key: value for key, value in lent.items() if value != default[key]}


def _longest_step(parameters: Mapping[str, Any]) -> float:
    """Return the longest step [s] with which a configuration is valid.

    Raises:
        Refusal: with the shortest step it is invalid, too; the first reason is given.
    """
    rate = Configuration().sensor.sampling_rate
    for count in range(2, MOST_STEPS):
        step = 1.0 / (rate * count)
        _, reasons = checked({**parameters, "simulation.step": step}, Configuration)
        if not reasons:
            return step
        if not any("simulation.step" in reason for reason in reasons):
            break
    raise Refusal(reasons[0])


def _cylinder(diameter: float, length: float) -> float:
    """Return the mass of a steel cylinder with dimensions in mm [kg]."""
    return STEEL_DENSITY * 1e-9 * 0.25 * math.pi * diameter**2 * length


def _tube(inside: float, outside: float, length: float) -> float:
    """Return the mass of a steel tube with dimensions in mm [kg]."""
    return _cylinder(outside, length) - _cylinder(inside, length)


def _rounded(value: float) -> float:
    """Return a number with six significant digits, as it is written."""
    return float(f"{value:.6g}")


def described_yaml(parameters: Mapping[str, Any], filled: list[FilledIn], title: str) -> str:
    """Return a ROS parameter file whose comments say which values were filled in, and from what."""
    sources = {entry.key: entry.source for entry in filled}
    lines = [
        f"# {title}",
        "# Grease, surfaces, damping and drive are those of the bench healthy.",
        "# Spreads of rollers and pockets are those of healthy times the cube root of (roller diameter / 30 mm), below 30 mm.",
        "/**:",
        "  ros__parameters:",
    ]
    for group, values in nest(parameters).items():
        lines.append(f"    {group}:")
        for name, value in values.items():
            source = sources.get(f"{group}.{name}")
            lines.append(f"      {name}: {yaml.safe_dump(value).partition(chr(10))[0]}" + (f"  # {source}" if source else ""))
    return "\n".join(lines) + "\n"

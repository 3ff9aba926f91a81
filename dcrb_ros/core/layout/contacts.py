"""The tables of the rollers' and the cages' contacts."""

from __future__ import annotations

from dcrb_ros.core.laws.interface import LubricationLaw, NormalLaw, TractionLaw
from dcrb_ros.core.laws.registry import fields_of
from dcrb_ros.core.layout.records import ByLaw, Indices, Lanes


class NormalMemory:
    """Memory of the law of the normal force; its arrays are the fields of `NormalLaw.memory`."""


class TractionMemory:
    """Memory of the law of traction at raceways and between rollers; its arrays are the fields of `TractionLaw.memory`."""


class TractionKept:
    """What that law keeps for the end of the step; its arrays are the fields of `TractionLaw.kept`."""


class FilmMemory:
    """What the film remembers of a contact; its arrays are the fields of `LubricationLaw.memory`."""


class CageTractionMemory:
    """Memory of the law of traction at bars and lands."""


class CageTractionKept:
    """What that law keeps for the end of the step."""


class RacewayState:
    """What lasts of the rollers' contacts with one raceway from step to step."""

    normal: NormalMemory
    traction: TractionMemory
    force: Lanes
    """Normal force over the last step [N]."""
    friction: Lanes
    """Friction force over the last step [N]."""
    slip: Lanes
    """Slip over the last step [m/s]."""
    film: FilmMemory


class BarState:
    """What lasts of the rollers' contacts with their bars from step to step."""

    traction: CageTractionMemory
    force: Lanes
    """Normal force over the last step, positive at the bar ahead [N]."""
    impact_speed: Lanes
    """Speed at which the contact closed [m/s]; 0 while it is open."""


class PairState:
    """What lasts of the contacts of rollers with the next ones, where the bar between them is broken."""

    normal: NormalMemory
    traction: TractionMemory
    force: Lanes
    """Normal force over the last step [N]."""


class LandState:
    """What lasts of the contacts of the cages with the outer ring's lands; one element per row."""

    traction: CageTractionMemory
    force: Lanes
    """Normal force over the last step [N]."""
    impact_speed: Lanes
    """Speed at which the contact closed [m/s]; 0 while it is open."""
    loss: Lanes
    """Energy lost in friction and contact [J]; only with oil."""


class RacewayContact:
    """The contacts of bound rollers with one raceway in a step.

    Normal force = force_offset + force_slope * approach, friction = friction_offset + friction_slope * slip.
    """

    radial_x: Lanes
    """Direction from the ring's centre to the roller's [-]."""
    radial_y: Lanes
    distance: Lanes
    """Distance of the centres [m]."""
    normal_x: Lanes
    """Contact normal, the radial direction but at the edges of a notch [-]."""
    normal_y: Lanes
    penetration: Lanes
    """In the middle of the step; below zero for a gap [m]."""
    sink_speed: Lanes
    """Speed at which the floor of a notch falls away [m/s]."""
    surface_speed_normal: Lanes
    """Speed of the ring's surface along the normal, other than zero at the edges of a notch [m/s]."""
    tilt: Lanes
    """Slope of the raceway along which the normal is tilted [-]."""
    part_height: Lanes
    """Height over a part of the roller's length, beside that over the whole [m]."""
    part_tilt: Lanes
    """Slope of that height along the raceway [-]."""
    share: Lanes
    """Share of the length that it takes; 0 without a defect [-]."""
    crossing: Lanes
    """1 where the contact closes or opens within the step."""
    last_force: Lanes
    """Normal force over the last step [N]."""
    expected_force: Lanes
    """Normal force expected at the predicted velocities [N]."""
    expected_closing: Lanes
    """Speed of penetration at which that is so [m/s]."""
    damping: Lanes
    """Damping within the slope of the normal force [N s/m]."""
    force_offset: Lanes
    """[N]"""
    force_slope: Lanes
    """[N s/m]"""
    normal: NormalMemory
    """At the beginning of the step, and then at its end."""
    traction: TractionMemory
    """At the beginning of the step, and then at its end."""
    kept: TractionKept
    friction_offset: Lanes
    """[N]"""
    friction_slope: Lanes
    """[N s/m]"""
    force: Lanes
    """Normal force over the step, as found [N]."""
    friction: Lanes
    """Friction force over the step, as found [N]."""
    slip: Lanes
    """Slip over the step, as found [m/s]."""
    film: FilmMemory
    """Its resistance to rolling is that of this step, zero for an open contact."""


class BarContact:
    """The contacts of bound rollers with their bars in a step; the normal is the pocket's tangent. Lines as in `RacewayContact`."""

    side: Lanes
    """1 for the bar ahead of the roller, -1 for the one behind, 0 for no bar in reach."""
    lever_x: Lanes
    """From the cage's centre to the contact [m]."""
    lever_y: Lanes
    impact_speed: Lanes
    """Speed at which the contact closed [m/s]; 0 while it is open."""
    damping: Lanes
    """Damping within the slope of the normal force [N s/m]."""
    force_offset: Lanes
    """[N]"""
    force_slope: Lanes
    """[N s/m]"""
    traction: CageTractionMemory
    """At the beginning of the step, and then at its end."""
    kept: CageTractionKept
    friction_offset: Lanes
    """[N]"""
    friction_slope: Lanes
    """[N s/m]"""
    force: Lanes
    """Normal force over the step, as found [N]."""


class ConformalContacts:
    """The conformal contacts of a step: lands in reach of their cages, then bars in reach of bound rollers."""

    owner: Indices
    """Row of the cage, or element of `BoundRollers` of the roller."""
    normal_x: Lanes
    """Direction from the outer ring's centre to the cage's; of lands [-]."""
    normal_y: Lanes
    penetration: Lanes
    """At the beginning of the step [m]."""
    closing_before: Lanes
    """Speed of penetration before the step [m/s]."""
    closing: Lanes
    """Mean speed of penetration over the step: predicted with the force of the last step, then with its own [m/s]."""
    slip: Lanes
    """As predicted [m/s]."""
    force: Lanes
    """Normal force over the last step; of lands then of the last sweep [N]."""
    impact_speed: Lanes
    """Speed at which the contact closed [m/s]; 0 while it is open."""
    coefficient: Lanes
    """Coefficient of the contact's law [N/m^exponent]."""
    exponent: Lanes
    """Exponent of the contact's law [-]."""
    mobility: Lanes
    """Change of the mean speed of penetration with the force: half the step over the bodies' reduced mass [m/(N s)]."""
    elastic_force: Lanes
    """[N]"""
    elastic_slope: Lanes
    """Slope of the elastic force over the mean speed of penetration [N s/m]."""
    damping: Lanes
    """[N s/m]"""
    traction: CageTractionMemory
    """At the beginning of the step."""
    kept: CageTractionKept
    friction_offset: Lanes
    """Friction per normal force without slip [-]."""
    friction_slope: Lanes
    """Its slope over the slip [s/m]."""


def by_law(normal: NormalLaw, traction: TractionLaw, cage_traction: TractionLaw, lubrication: LubricationLaw) -> ByLaw:
    """Return the arrays that the laws of a bearing name in these tables."""
    return (
        (NormalMemory, fields_of(normal.memory)),
        (TractionMemory, fields_of(traction.memory)),
        (TractionKept, fields_of(traction.kept)),
        (FilmMemory, fields_of(lubrication.memory)),
        (CageTractionMemory, fields_of(cage_traction.memory)),
        (CageTractionKept, fields_of(cage_traction.kept)),
    )

"""The tables of rollers and of their contacts."""

from __future__ import annotations

from dcrb_ros.core.laws.interface import LubricationLaw, NormalLaw, TractionLaw, fields_of
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


class Rollers:
    """The state of all rollers, row by row."""

    x: Lanes
    """Centre [m]; that of pinned rollers only when observed."""
    y: Lanes
    vx: Lanes
    """Velocity [m/s]; that of pinned rollers only when observed."""
    vy: Lanes
    spin: Lanes
    """Absolute spin [rad/s]."""
    change_vx: Lanes
    """Change of velocity over the last step [m/s], from which the next one is predicted."""
    change_vy: Lanes
    change_spin: Lanes
    """Change of spin over the last step [rad/s]."""
    angle: Lanes
    """Absolute rotation [rad]."""
    inner: RacewayState
    outer: RacewayState
    bar: BarState
    pair: PairState
    pocket_tangent_x: Lanes
    """Pocket tangent at cage angle zero [-]."""
    pocket_tangent_y: Lanes
    free: Lanes
    """1 for a free roller, 0 for a pinned one."""
    second_row: Lanes
    """1 in the second row, 0 in the first."""
    friction_loss: Lanes
    """Energy lost in friction with raceways and bars, and in rolling [J]."""
    rolling_loss: Lanes
    """The part of it lost in the resistance of films to rolling [J]."""
    contact_loss: Lanes
    """Energy lost in normal contacts [J]."""
    notch_loss: Lanes
    """Energy taken by the notch law [J]."""
    drive_work: Lanes
    """Work of the shaft [J]."""


class RollerStep:
    """All rollers in the middle of a step."""

    x: Lanes
    """Centre [m]."""
    y: Lanes
    tangent_x: Lanes
    """Pocket tangent [-]."""
    tangent_y: Lanes
    near_outer: Lanes
    """Above zero where the contact with the outer raceway is closed or may close within the step [m^2]."""
    near_bar: Lanes
    """The same of a bar [m]."""
    bound: Lanes
    """1 for a bound roller, 0 for one that is not."""
    over_notch: Lanes
    """1 where a notch may lie under a free roller at the outer raceway."""
    notch_depth: Lanes
    """Depth of notches under a free roller at the outer raceway [m]."""
    sink_speed: Lanes
    """Speed at which that depth grows [m/s]."""
    height: Lanes
    """Height of the outer raceway and of the roller at their contact [m]."""
    tilt: Lanes
    """Slope of the outer raceway there [-]."""
    over_part: Lanes
    """1 where a defect of the outer raceway takes a share of the length there."""
    force_on_outer_x: Lanes
    """Force on the outer ring from a free roller that is not bound [N]."""
    force_on_outer_y: Lanes


class Nodes:
    """Where contacts with one raceway lie on the tables of heights, and the values on both sides."""

    node: Indices
    """Node of the raceway before the contact."""
    way: Lanes
    """Way from there [nodes]."""
    roller_node: Indices
    """The same of the roller's own heights."""
    roller_way: Lanes
    before: Indices
    """Height [m] and slope [m/rad] of the raceway at that node, in single precision side by side."""
    after: Indices
    """The same at the next node."""
    own_before: Indices
    """The same of the roller's own heights."""
    own_after: Indices


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
    part_slope: Lanes
    """[m/rad]"""
    share: Lanes
    """Share of the length that it takes; 0 for none [-]."""
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
    """1 for the bar ahead of the roller, -1 for the one behind, 0 for none in reach."""
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


class BoundRollers:
    """The bound rollers of a step, side by side, row by row; filled up with copies of the last one to a multiple of `VECTOR`."""

    roller: Indices
    """Which roller this is, in the order of `Rollers`."""
    row: Indices
    """The roller's row."""
    crossings: Indices
    """The elements whose contact with a raceway closes or opens within the step, listed from the front."""
    free: Lanes
    """1 for a free roller, 0 for a pinned one."""
    second_row: Lanes
    """1 in the second row, 0 in the first."""
    x: Lanes
    """Centre in the middle of the step [m]."""
    y: Lanes
    tangent_x: Lanes
    """Pocket tangent [-]."""
    tangent_y: Lanes
    near_bar: Lanes
    """Above zero where the contact with a bar is closed or may close within the step [m]."""
    vx: Lanes
    """Velocity before the step [m/s]."""
    vy: Lanes
    spin: Lanes
    """Spin before the step [rad/s]."""
    rim: Lanes
    """Speed r_R omega_R of the roller's surface before the step [m/s]."""
    change_vx: Lanes
    """Change of velocity over the last step [m/s]."""
    change_vy: Lanes
    change_spin: Lanes
    """[rad/s]"""
    predicted_vx: Lanes
    """Mean velocity over the step, as predicted [m/s]."""
    predicted_vy: Lanes
    predicted_rim: Lanes
    contact_free_vx: Lanes
    """Mean velocity over the step without the contacts with raceways and bars [m/s]."""
    contact_free_vy: Lanes
    contact_free_rim: Lanes
    rhs_x: Lanes
    """Right-hand side of the roller's equations without the velocities of the bodies that it touches [N s]."""
    rhs_y: Lanes
    rhs_rim: Lanes
    inverse_xx: Lanes
    """Inverse of the matrix of the equations in X and Y [1/kg]."""
    inverse_xy: Lanes
    inverse_yy: Lanes
    inverse_rim: Lanes
    """Inverse of the coefficient of the equation for the surface speed [1/kg]."""
    coupling_x: Lanes
    """Coefficient of the velocity in the equation for the surface speed, times ``inverse_rim`` [-]."""
    coupling_y: Lanes
    mean_vx: Lanes
    """Mean velocity over the step, as found [m/s]."""
    mean_vy: Lanes
    mean_rim: Lanes
    force_on_inner_x: Lanes
    """Force on the inner ring [N]."""
    force_on_inner_y: Lanes
    force_on_outer_x: Lanes
    """Force on the outer ring [N]."""
    force_on_outer_y: Lanes
    force_on_cage_x: Lanes
    """Force on the cage [N]."""
    force_on_cage_y: Lanes
    torque_on_cage: Lanes
    """[N m]"""
    friction_power: Lanes
    """Power lost in friction and rolling [W]."""
    rolling_power: Lanes
    """The part of it lost in the resistance of films to rolling [W]; written only where there is any."""
    loss_power: Lanes
    """Power lost in normal contacts [W]."""
    notch_power: Lanes
    """Power taken by the notch law [W]."""
    drive_power: Lanes
    """Power of the shaft [W]."""
    inner: RacewayContact
    outer: RacewayContact
    bar: BarContact


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

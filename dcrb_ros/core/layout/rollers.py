"""The tables of rollers."""

from __future__ import annotations

from dcrb_ros.core.layout.contacts import BarContact, BarState, PairState, RacewayContact, RacewayState
from dcrb_ros.core.layout.records import Indices, Lanes


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
    pocket_clearance: Lanes
    """Clearance to a bar, on either side [m]."""
    spin_drag: Lanes
    """Drag of the oil at both bars over the speed of the roller's surface past them [N s/m]."""
    free: Lanes
    """1 for a free roller, 0 for a pinned one."""
    second_row: Lanes
    """1 in the second row, 0 in the first."""
    friction_loss: Lanes
    """Energy lost in friction with raceways and bars, and in rolling [J]."""
    rolling_loss: Lanes
    """The part of it lost in the resistance of films to rolling [J]."""
    drag_loss: Lanes
    """The part of it lost in the drag of oil at bars and about the rollers [J]."""
    contact_loss: Lanes
    """Energy lost in normal contacts and the squeezing of films [J]."""
    bar_friction_loss: Lanes
    """The part of the friction lost at bars and in the drag of oil [J]; only with oil."""
    bar_contact_loss: Lanes
    """The part of the contacts' losses at bars and in their films [J]; only with oil."""
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
    bar_film: Lanes
    """Damping of the film at the bar that a free roller approaches, positive at the bar ahead [N s/m]; only with oil."""
    force_on_cage_x: Lanes
    """Force of that film on the cage, from a free roller that is not bound [N]; only with oil."""
    force_on_cage_y: Lanes
    torque_on_cage: Lanes
    """Torque of the oil on the cage [N m]; only with oil."""


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
    roller_before: Indices
    """The same of the roller's own heights."""
    roller_after: Indices


class BoundRollers:
    """The bound rollers of a step, side by side, row by row; filled up with copies of the last one to a multiple of `WIDTH`."""

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
    bar_film: Lanes
    """As in `RollerStep`."""
    spin_drag: Lanes
    """As in `Rollers`."""
    drag: Lanes
    """Drag on the roller's surface [N]; only with oil."""
    drag_power: Lanes
    """Power lost in the drag of oil [W]; only with oil."""
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
    bar_friction_power: Lanes
    """Power lost in friction at the bar [W]; only with oil."""
    bar_loss_power: Lanes
    """Power lost in the contact with it [W]; only with oil."""
    notch_power: Lanes
    """Power taken by the notch law [W]."""
    drive_power: Lanes
    """Power of the shaft [W]."""
    inner: RacewayContact
    outer: RacewayContact
    bar: BarContact

"""The state of the bearing, its one place: arrays that the time loop changes in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core import lanes
from dcrb_ros.core.payload import Floats

LOAD, FRICTION, LOSS, HOUSING = range(4)
ACCOUNTS = 4
"""Entries of the energy account that belong to no roller in its lane [J]: work of the load; losses in friction and contacts between rollers
and of lands; loss in the housing."""


class State(NamedTuple):
    """Positions, velocities and contact memory; SI units, X right, Y up, counter-clockwise positive.

    What belongs to a roller is a view of ``lanes``, in which the kernels find it.
    """

    lanes: Floats
    """All that belongs to rollers, field by field, see `dcrb_ros.core.lanes`."""
    outer_position: Floats
    """Centre of the outer ring, shape (2,) [m]."""
    outer_velocity: Floats
    """Shape (2,) [m/s]."""
    outer_change: Floats
    """Change of velocity over the last step, from which the next one's is predicted, shape (2,) [m/s]."""
    inner_position: Floats
    """Centre of the inner ring, shape (2,) [m]."""
    inner_velocity: Floats
    """Shape (2,) [m/s]."""
    inner_change: Floats
    """Shape (2,) [m/s]."""
    cage_position: Floats
    """Centre X, Y [m] and angle [rad] of each cage, shape (rows, 3)."""
    cage_velocity: Floats
    """Shape (rows, 3) [m/s, m/s, rad/s]."""
    cage_change: Floats
    """Shape (rows, 3) [m/s, m/s, rad/s]."""
    earlier_change: Floats
    """Changes of outer ring, inner ring and cages over the step before the last, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    roller_position: Floats
    """Centre X, Y of each roller, shape (rows, rollers, 2) [m]; of pinned ones when observed."""
    roller_velocity: Floats
    """Velocity of each roller X, Y [m/s], and its spin [rad/s], shape (rows, rollers, 3); X, Y of pinned ones when observed."""
    roller_change: Floats
    """Shape (rows, rollers, 3) [m/s, m/s, rad/s]."""
    spin_angle: Floats
    """Absolute rotation of each roller, shape (rows, rollers) [rad]; like all that follow up to the land."""
    inner_bristle: Floats
    """Bristle deflection at the inner raceway [m]."""
    outer_bristle: Floats
    bar_bristle: Floats
    next_bristle: Floats
    """Between a roller and the next one, where the bar between them is broken."""
    inner_force: Floats
    """Normal force at the inner raceway over the last step [N]."""
    outer_force: Floats
    bar_force: Floats
    """Normal force at the bar, positive at the one ahead [N]."""
    next_force: Floats
    inner_friction: Floats
    """Friction force at the inner raceway over the last step [N]."""
    outer_friction: Floats
    inner_slip: Floats
    """Slip s_I at the inner raceway over the last step [m/s]; of open contacts too when observed."""
    outer_slip: Floats
    bar_impact: Floats
    """Speed at which a bar's contact closed [m/s]; 0 while it is open."""
    land_impact: Floats
    """The same of each cage's land, shape (rows,)."""
    land_bristle: Floats
    """Shape (rows,) [m]."""
    land_force: Floats
    """Normal force between each cage and the outer ring's land, shape (rows,) [N]."""
    shaft: Floats
    """Angle [rad] and speed [rad/s] of the inner ring, shape (2,)."""
    load: Floats
    """Force on the inner ring, shape (2,) [N]."""
    target: Floats
    """Commanded speed [rad/s] and load in X and Y [N], shape (3,)."""
    account: Floats
    """Energy account since the start without what rollers keep, shape (ACCOUNTS,) [J]."""
    friction_loss: Floats
    """Lost in friction of each roller with raceways and bars, shape (rows, rollers) [J]; like all that follow."""
    contact_loss: Floats
    """Lost in normal contacts."""
    notch_loss: Floats
    """Taken by the notch law: it has depth, but no tangential force at the edge that would do the work."""
    drive_work: Floats
    """Work of the shaft."""


def empty_state(rows: int, rollers: int) -> State:
    """Return a state of zeros for ``rows`` rows of ``rollers`` rollers."""
    return _state_of(lanes.empty_lanes(lanes.STATE_FIELDS), rows, rollers)


def copy_of(state: State) -> State:
    """Return a state that has nothing in common with another but its values."""
    found = empty_state(*state.next_force.shape)
    for part, other in zip(found, state, strict=True):
        part[...] = other
    return found


def _state_of(buffer: Floats, rows: int, rollers: int) -> State:
    def rolling(field: int, parts: int = 0) -> Floats:
        return lanes.field_of(buffer, field, rows, rollers, parts)

    return State(
        lanes=buffer,
        outer_position=np.zeros(2),
        outer_velocity=np.zeros(2),
        outer_change=np.zeros(2),
        inner_position=np.zeros(2),
        inner_velocity=np.zeros(2),
        inner_change=np.zeros(2),
        cage_position=np.zeros((rows, 3)),
        cage_velocity=np.zeros((rows, 3)),
        cage_change=np.zeros((rows, 3)),
        earlier_change=np.zeros((2 + rows, 3)),
        roller_position=rolling(lanes.X, 2),
        roller_velocity=rolling(lanes.VX, 3),
        roller_change=rolling(lanes.CHANGE_X, 3),
        spin_angle=rolling(lanes.ANGLE),
        inner_bristle=rolling(lanes.INNER_BRISTLE),
        outer_bristle=rolling(lanes.OUTER_BRISTLE),
        bar_bristle=rolling(lanes.BAR_BRISTLE),
        inner_force=rolling(lanes.INNER_FORCE),
        outer_force=rolling(lanes.OUTER_FORCE),
        bar_force=rolling(lanes.BAR_FORCE),
        inner_friction=rolling(lanes.INNER_FRICTION),
        outer_friction=rolling(lanes.OUTER_FRICTION),
        inner_slip=rolling(lanes.INNER_SLIP),
        outer_slip=rolling(lanes.OUTER_SLIP),
        bar_impact=rolling(lanes.BAR_IMPACT),
        next_bristle=np.zeros((rows, rollers)),
        next_force=np.zeros((rows, rollers)),
        land_impact=np.zeros(rows),
        land_bristle=np.zeros(rows),
        land_force=np.zeros(rows),
        shaft=np.zeros(2),
        load=np.zeros(2),
        target=np.zeros(3),
        account=np.zeros(ACCOUNTS),
        friction_loss=rolling(lanes.FRICTION_LOSS),
        contact_loss=rolling(lanes.CONTACT_LOSS),
        notch_loss=rolling(lanes.NOTCH_LOSS),
        drive_work=rolling(lanes.DRIVE_WORK),
    )

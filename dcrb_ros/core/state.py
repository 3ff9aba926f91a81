"""The state of the bearing, its one place: arrays that the time loop changes in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core import lanes
from dcrb_ros.core.payload import Floats

OUTER, INNER, CAGE = 0, 1, 2
"""Bodies that rollers touch: the rings, then the cages row by row."""
LOAD, FRICTION, LOSS, HOUSING = range(4)
ACCOUNTS = 4
"""Entries of the energy account that belong to no roller in its lane [J]: work of the load; losses in friction and contacts between rollers
and of lands; loss in the housing."""


class State(NamedTuple):
    """Positions, velocities and contact memory; SI units, X right, Y up, counter-clockwise positive.

    Its fields are what the kernels take, few because each costs compile time; what belongs to one body or to the rollers are views.
    """

    lanes: Floats
    """All that belongs to rollers, field by field, see `dcrb_ros.core.lanes`."""
    position: Floats
    """Centre X, Y [m] and angle [rad] of outer ring, inner ring and cages, shape (2 + rows, 3); the rings' angles stay
    zero, for the inner ring's see ``shaft``."""
    velocity: Floats
    """Shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    change: Floats
    """Change of velocity over the last step, from which the next one's is predicted, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    earlier_change: Floats
    """The same over the step before the last."""
    next_bristle: Floats
    """Bristle deflection between a roller and the next one, where the bar between them is broken, shape (rows, rollers) [m]."""
    next_force: Floats
    """Normal force between them over the last step, shape (rows, rollers) [N]."""
    land_impact: Floats
    """Speed at which the contact of each cage with the outer ring's land closed, shape (rows,) [m/s]; 0 while it is open."""
    land_bristle: Floats
    """Shape (rows,) [m]."""
    land_force: Floats
    """Normal force of each cage and its land, shape (rows,) [N]."""
    shaft: Floats
    """Angle [rad] and speed [rad/s] of the inner ring, shape (2,)."""
    load: Floats
    """Force on the inner ring, shape (2,) [N]."""
    target: Floats
    """Commanded speed [rad/s] and load in X and Y [N], shape (3,)."""
    account: Floats
    """Energy account since the start without what rollers keep, shape (ACCOUNTS,) [J]."""

    def of_rollers(self, field: int, parts: int = 0) -> Floats:
        """Return the view of a field of the lanes, shape (rows, rollers), or of ``parts`` fields that follow each other."""
        rows, rollers = self.next_force.shape
        return lanes.field_of(self.lanes, field, rows, rollers, parts)

    @property
    def outer_position(self) -> Floats:
        """Centre of the outer ring, shape (2,) [m]."""
        return self.position[OUTER, :2]

    @property
    def outer_velocity(self) -> Floats:
        """Shape (2,) [m/s]."""
        return self.velocity[OUTER, :2]

    @property
    def inner_position(self) -> Floats:
        """Centre of the inner ring, shape (2,) [m]."""
        return self.position[INNER, :2]

    @property
    def inner_velocity(self) -> Floats:
        """Shape (2,) [m/s]."""
        return self.velocity[INNER, :2]

    @property
    def cage_position(self) -> Floats:
        """Centre X, Y [m] and angle [rad] of each cage, shape (rows, 3)."""
        return self.position[CAGE:]

    @property
    def cage_velocity(self) -> Floats:
        """Shape (rows, 3) [m/s, m/s, rad/s]."""
        return self.velocity[CAGE:]

    @property
    def roller_position(self) -> Floats:
        """Centre X, Y of each roller, shape (rows, rollers, 2) [m]; of pinned ones when observed."""
        return self.of_rollers(lanes.X, 2)

    @property
    def roller_velocity(self) -> Floats:
        """Velocity of each roller X, Y [m/s], and its spin [rad/s], shape (rows, rollers, 3); X, Y of pinned ones when observed."""
        return self.of_rollers(lanes.VX, 3)

    @property
    def roller_change(self) -> Floats:
        """Shape (rows, rollers, 3) [m/s, m/s, rad/s]."""
        return self.of_rollers(lanes.CHANGE_X, 3)

    @property
    def spin_angle(self) -> Floats:
        """Absolute rotation of each roller, shape (rows, rollers) [rad]; like all that follow."""
        return self.of_rollers(lanes.ANGLE)

    @property
    def inner_bristle(self) -> Floats:
        """Bristle deflection at the inner raceway [m]."""
        return self.of_rollers(lanes.INNER_BRISTLE)

    @property
    def outer_bristle(self) -> Floats:
        """Bristle deflection at the outer raceway [m]."""
        return self.of_rollers(lanes.OUTER_BRISTLE)

    @property
    def bar_bristle(self) -> Floats:
        """Bristle deflection at the bar [m]."""
        return self.of_rollers(lanes.BAR_BRISTLE)

    @property
    def inner_force(self) -> Floats:
        """Normal force at the inner raceway over the last step [N]."""
        return self.of_rollers(lanes.INNER_FORCE)

    @property
    def outer_force(self) -> Floats:
        """Normal force at the outer raceway over the last step [N]."""
        return self.of_rollers(lanes.OUTER_FORCE)

    @property
    def bar_force(self) -> Floats:
        """Normal force at the bar, positive at the one ahead [N]."""
        return self.of_rollers(lanes.BAR_FORCE)

    @property
    def inner_friction(self) -> Floats:
        """Friction force at the inner raceway over the last step [N]."""
        return self.of_rollers(lanes.INNER_FRICTION)

    @property
    def outer_friction(self) -> Floats:
        """Friction force at the outer raceway over the last step [N]."""
        return self.of_rollers(lanes.OUTER_FRICTION)

    @property
    def inner_slip(self) -> Floats:
        """Slip s_I at the inner raceway over the last step [m/s]."""
        return self.of_rollers(lanes.INNER_SLIP)

    @property
    def outer_slip(self) -> Floats:
        """Slip s_O at the outer raceway over the last step [m/s]."""
        return self.of_rollers(lanes.OUTER_SLIP)

    @property
    def bar_impact(self) -> Floats:
        """Speed at which a bar's contact closed [m/s]; 0 while it is open."""
        return self.of_rollers(lanes.BAR_IMPACT)

    @property
    def friction_loss(self) -> Floats:
        """Energy lost in friction with raceways and bars [J]."""
        return self.of_rollers(lanes.FRICTION_LOSS)

    @property
    def contact_loss(self) -> Floats:
        """Energy lost in normal contacts [J]."""
        return self.of_rollers(lanes.CONTACT_LOSS)

    @property
    def notch_loss(self) -> Floats:
        """Energy taken by the notch law: it has depth, but no tangential force at the edge that would do the work [J]."""
        return self.of_rollers(lanes.NOTCH_LOSS)

    @property
    def drive_work(self) -> Floats:
        """Work of the shaft [J]."""
        return self.of_rollers(lanes.DRIVE_WORK)


def empty_state(rows: int, rollers: int) -> State:
    """Return a state of zeros for ``rows`` rows of ``rollers`` rollers."""
    bodies = CAGE + rows
    return State(
        lanes=lanes.empty_lanes(lanes.STATE_FIELDS),
        position=np.zeros((bodies, 3)),
        velocity=np.zeros((bodies, 3)),
        change=np.zeros((bodies, 3)),
        earlier_change=np.zeros((bodies, 3)),
        next_bristle=np.zeros((rows, rollers)),
        next_force=np.zeros((rows, rollers)),
        land_impact=np.zeros(rows),
        land_bristle=np.zeros(rows),
        land_force=np.zeros(rows),
        shaft=np.zeros(2),
        load=np.zeros(2),
        target=np.zeros(3),
        account=np.zeros(ACCOUNTS),
    )


def copy_of(state: State) -> State:
    """Return a state that has nothing in common with another but its values."""
    found = empty_state(*state.next_force.shape)
    for part, other in zip(found, state, strict=True):
        part[...] = other
    return found

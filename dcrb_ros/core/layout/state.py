"""The state of the bearing: the arrays that the time loop changes in place."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.core.layout.contacts import LandState
from dcrb_ros.core.layout.records import Floats, Integers, Lanes, OneRecord, copy_of_record, empty_record, view_of
from dcrb_ros.core.layout.rollers import Rollers
from dcrb_ros.core.payload import Payload, arrays_by_law

OUTER, INNER, CAGE = 0, 1, 2
"""Bodies that rollers touch: the rings, then the cages row by row."""
SHAFT_ANGLE, SHAFT_SPEED = range(2)
"""Entries of `State.shaft`."""
TARGET_SPEED, TARGET_X, TARGET_Y = range(3)
"""Entries of `State.target`."""
LOAD, FRICTION, LOSS, HOUSING = range(4)
ACCOUNTS = 4
"""Entries of the energy account that belong to no roller [J]: work of the load; losses in friction and contacts between rollers and of
lands; loss in the housing."""


class State(NamedTuple):
    """Positions, velocities and contact memory; SI units, X right, Y up, counter-clockwise positive.

    The kernels take the fields; the properties are views of them for everybody else.
    """

    rollers: OneRecord[Rollers]
    """All that belongs to rollers; see `of_rollers`."""
    land: OneRecord[LandState]
    """The contact of each cage with the outer ring's land."""
    position: Floats
    """Centre X, Y [m] and angle [rad] of outer ring, inner ring and cages, shape (2 + rows, 3); the rings' angles stay
    zero, for the inner ring's see ``shaft``."""
    velocity: Floats
    """Shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    change: Floats
    """Change of velocity over the last step, from which the next one's is predicted, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    earlier_change: Floats
    """The same over the step before the last."""
    shaft: Floats
    """Angle [rad] and speed [rad/s] of the inner ring, shape (2,)."""
    load: Floats
    """Force on the inner ring, shape (2,) [N]."""
    target: Floats
    """Commanded speed [rad/s] and load in X and Y [N], shape (3,)."""
    account: Floats
    """Energy account since the start without what is kept per roller, shape (ACCOUNTS,) [J]."""
    films: Floats
    """The films of inner and outer raceway as they were evaluated last, shape (2, numbers of the film) [-]."""
    tick: Integers
    """Steps since the start, shape (1,) [-]."""
    rollers_per_row: int

    def of_rollers(self, values: Lanes) -> Floats:
        """Return the view of an array of ``rollers``, shape (rows, rollers)."""
        rows = len(self.position) - CAGE
        return values[: rows * self.rollers_per_row].reshape(rows, self.rollers_per_row)

    def _vectors(self, first: str, parts: int) -> Floats:
        return view_of(self.rollers, first, parts, len(self.position) - CAGE, self.rollers_per_row)

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
        return self._vectors("x", 2)

    @property
    def roller_velocity(self) -> Floats:
        """Velocity of each roller X, Y [m/s], and its spin [rad/s], shape (rows, rollers, 3); X, Y of pinned ones when observed."""
        return self._vectors("vx", 3)

    @property
    def roller_change(self) -> Floats:
        """Change of these over the last step, shape (rows, rollers, 3) [m/s, m/s, rad/s]."""
        return self._vectors("change_vx", 3)

    @property
    def spin_angle(self) -> Floats:
        """Absolute rotation of each roller, shape (rows, rollers) [rad]."""
        return self.of_rollers(self.rollers[0].angle)

    @property
    def inner_force(self) -> Floats:
        """Normal force at the inner raceway over the last step, shape (rows, rollers) [N]."""
        return self.of_rollers(self.rollers[0].inner.force)

    @property
    def outer_force(self) -> Floats:
        """Normal force at the outer raceway over the last step, shape (rows, rollers) [N]."""
        return self.of_rollers(self.rollers[0].outer.force)


def empty_state(payload: Payload) -> State:
    """Return a state of zeros for a bearing."""
    (rows, rollers), by_law = payload.free.shape, arrays_by_law(payload)
    bodies = CAGE + rows
    return State(
        rollers=empty_record(Rollers, by_law),
        land=empty_record(LandState, by_law),
        position=np.zeros((bodies, 3)),
        velocity=np.zeros((bodies, 3)),
        change=np.zeros((bodies, 3)),
        earlier_change=np.zeros((bodies, 3)),
        shaft=np.zeros(2),
        load=np.zeros(2),
        target=np.zeros(3),
        account=np.zeros(ACCOUNTS),
        films=np.zeros((2, max(len(payload.inner.film), 1))),
        tick=np.zeros(1, np.int64),
        rollers_per_row=rollers,
    )


def copy_of(state: State) -> State:
    """Return a state with the same values and arrays of its own."""
    tables: dict[str, Any] = {name: copy_of_record(getattr(state, name)) for name in ("rollers", "land")}
    arrays = {name: part.copy() for name, part in state._asdict().items() if name not in tables and isinstance(part, np.ndarray)}
    return state._replace(**arrays | tables)

"""Scratch arrays of the time loop and where everything stands in them; nothing in them outlives a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core.payload import Floats, Integers, Payload

OUTER, INNER, CAGE = 0, 1, 2
"""Bodies that rollers touch: the rings, then the cages row by row."""

ROLLER, COUNT, TIGHT, LONE, TAU_X, TAU_Y, MEAN_X, MEAN_Y, MEAN_RIM = range(9)
"""A roller's record: its index, its closed contacts, whether it is squeezed or has at most one contact, its pocket's tangent,
its mean velocity and surface speed r_R omega_R over the step."""
HEAD = 9
(
    BODY,
    SIDE,
    NORMAL_X,
    NORMAL_Y,
    TANGENT_X,
    TANGENT_Y,
    TURN,
    PUSH,
    GIVE,
    CONSTANT,
    SLOPE,
    RATE,
    PHI,
    FORCE,
    DAMPING,
    SINK,
    LEVER_X,
    LEVER_Y,
    SURFACE_N,
    SURFACE_T,
) = range(20)
"""A contact within a record: the body touched; the sign of the normal force on the roller; normal, tangent, and the sign
of the roller's surface speed in the slip; normal force PUSH + GIVE * approach; friction CONSTANT + SLOPE * slip and its
bristle's law; normal force known beforehand, damping and sink speed; lever from the body's centre and surface speed of
the body along normal and tangent."""
FIELDS = 20
MOST_CONTACTS = 3
RECORD = HEAD + MOST_CONTACTS * FIELDS


class Workspace(NamedTuple):
    """Scratch arrays of the time loop."""

    mean: Floats
    """Mean velocities over the step of rings and cages, predicted at first, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    loose: Floats
    """Force and torque on them from rollers that are not squeezed, shape (2 + rows, 3) [N, N, N m]."""
    tight: Floats
    """The same from squeezed rollers."""
    external: Floats
    """Force and torque over r_R on free rollers from other rollers, shape (rows, rollers, 3) [N]."""
    records: Floats
    """One record per roller that takes part, row by row, shape (rows * rollers, RECORD)."""
    inner_towards: Floats
    """Directions of the inner ring's notches, shape (notches, 2) [-]."""
    outer_towards: Floats
    ends: Integers
    """Where the records of each row begin, and at last where they end, shape (rows + 1,)."""


def workspace(payload: Payload) -> Workspace:
    """Return scratch arrays for a bearing."""
    rows, rollers = payload.free.shape
    bodies = (2 + rows, 3)
    shapes = [bodies, bodies, bodies, (rows, rollers, 3), (rows * rollers, RECORD)]
    notches = [(payload.inner_notches.row.size, 2), (payload.outer_notches.row.size, 2)]
    return Workspace._make([*(np.zeros(shape) for shape in [*shapes, *notches]), np.zeros(rows + 1, np.int64)])

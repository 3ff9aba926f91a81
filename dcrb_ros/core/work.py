"""Scratch space of the time loop, laid out once so that nothing is allocated in the loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core.lanes import CONFORMAL_FIELDS, LANES, STEP_FIELDS, empty_lanes
from dcrb_ros.core.payload import Floats, Integers, Payload


class Workspace(NamedTuple):
    """Scratch arrays of the time loop."""

    mean: Floats
    """Mean velocities over the step of rings and cages, predicted at first, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    heading: Floats
    """Cosine and sine of each cage's angle, shape (rows, 2) [-]."""
    moment: Floats
    """Mass times lever of each cage's pinned rollers along their tangents, shape (rows, 2) [kg m]."""
    loose: Floats
    """Force and torque on them from everything but bound rollers, shape (2 + rows, 3) [N, N, N m]."""
    tight: Floats
    """The same from bound rollers."""
    external: Floats
    """Force and torque over r_R on free rollers from other rollers, shape (rows, rollers, 3) [N]."""
    light: Floats
    """All rollers in their order, see `dcrb_ros.core.lanes`."""
    bound: Floats
    """Bound rollers side by side."""
    conformal: Floats
    """Contacts of cages with lands and of rollers with bars."""
    touched: Integers
    """Row of the cage, or lane of ``bound`` of the roller, in each of these contacts; before, the lanes whose contact with
    a raceway closes or opens."""
    order: Integers
    """Which roller is in which lane of ``bound``, row by row."""
    rows: Integers
    """Row of the roller in each of these lanes."""
    ends: Integers
    """Where the bound rollers of each row end, shape (rows,)."""
    inner_towards: Floats
    """Directions of the inner ring's notches, shape (notches, 2) [-]."""
    outer_towards: Floats


def workspace(payload: Payload) -> Workspace:
    """Return scratch arrays for a bearing."""
    rows, rollers = payload.free.shape
    return Workspace(
        mean=np.zeros((2 + rows, 3)),
        heading=np.zeros((rows, 2)),
        moment=np.zeros((rows, 2)),
        loose=np.zeros((2 + rows, 3)),
        tight=np.zeros((2 + rows, 3)),
        external=np.zeros((rows, rollers, 3)),
        light=empty_lanes(STEP_FIELDS),
        bound=empty_lanes(STEP_FIELDS),
        conformal=empty_lanes(CONFORMAL_FIELDS),
        touched=np.zeros(LANES, np.int64),
        order=np.zeros(LANES, np.int64),
        rows=np.zeros(LANES, np.int64),
        ends=np.zeros(rows, np.int64),
        inner_towards=np.zeros((payload.inner_notches.row.size, 2)),
        outer_towards=np.zeros((payload.outer_notches.row.size, 2)),
    )

"""Scratch space of the time loop, laid out once so that nothing is allocated in the loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core.layout.contacts import ConformalContacts
from dcrb_ros.core.layout.records import Floats, Integers, OneRecord, empty_record
from dcrb_ros.core.layout.rollers import BoundRollers, Nodes, RollerStep
from dcrb_ros.core.payload import Payload, arrays_by_law


class Workspace(NamedTuple):
    """Scratch arrays of the time loop."""

    rollers: OneRecord[RollerStep]
    """All rollers in their order."""
    bound: OneRecord[BoundRollers]
    """Bound rollers side by side."""
    outer: OneRecord[Nodes]
    """Heights about the contacts of all rollers with the outer raceway."""
    inner: OneRecord[Nodes]
    """Heights about the contacts of bound rollers with the inner raceway."""
    conformal: OneRecord[ConformalContacts]
    """Contacts of cages with lands and of bound rollers with bars."""
    row_ends: Integers
    """Where the bound rollers of each row end, shape (rows,)."""
    mean_velocity: Floats
    """Mean velocities over the step of rings and cages, predicted at first, shape (2 + rows, 3) [m/s, m/s, rad/s]."""
    heading: Floats
    """Cosine and sine of each cage's angle, shape (rows, 2) [-]."""
    train_moment: Floats
    """Mass times lever of each cage's pinned rollers along their tangents, shape (rows, 2) [kg m]."""
    force_of_free: Floats
    """Force and torque on rings and cages from rollers that are not bound, shape (2 + rows, 3) [N, N, N m]."""
    force_of_bound: Floats
    """The same from bound rollers and between cages and lands."""
    land_film: Floats
    """The oil of each cage's lands, shape (rows, 6); see `dcrb_ros.core.contacts.cage_films`."""
    pair_force: Floats
    """Force, and torque over r_R, on free rollers from other rollers, shape (rows, rollers, 3) [N]."""
    inner_notch_direction: Floats
    """Directions of the inner ring's notches, shape (notches, 2) [-]."""
    outer_notch_direction: Floats


def workspace(payload: Payload) -> Workspace:
    """Return scratch arrays for a bearing."""
    (rows, rollers), by_law = payload.free.shape, arrays_by_law(payload)
    return Workspace(
        rollers=empty_record(RollerStep, by_law),
        bound=empty_record(BoundRollers, by_law),
        outer=empty_record(Nodes, by_law),
        inner=empty_record(Nodes, by_law),
        conformal=empty_record(ConformalContacts, by_law),
        row_ends=np.zeros(rows, np.int64),
        mean_velocity=np.zeros((2 + rows, 3)),
        heading=np.zeros((rows, 2)),
        train_moment=np.zeros((rows, 2)),
        force_of_free=np.zeros((2 + rows, 3)),
        force_of_bound=np.zeros((2 + rows, 3)),
        land_film=np.zeros((rows, 6)),
        pair_force=np.zeros((rows, rollers, 3)),
        inner_notch_direction=np.zeros((payload.inner_notches.row.size, 2)),
        outer_notch_direction=np.zeros((payload.outer_notches.row.size, 2)),
    )

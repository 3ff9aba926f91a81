"""The state of the bearing, its one place: arrays that the time loop changes in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core.payload import Floats

DRIVE, LOAD, FRICTION, LOSS, HOUSING, NOTCH = range(6)
ACCOUNTS = 6
"""Entries of the energy account [J]: work of the shaft and of the load; losses in friction, contacts and housing; what
the notch law takes (it has depth, but no tangential force at the edge that would do the work)."""


class State(NamedTuple):
    """Positions, velocities and contact memory; SI units, X right, Y up, counter-clockwise positive."""

    outer_position: Floats
    """Centre of the outer ring, shape (2,) [m]."""
    outer_velocity: Floats
    """Shape (2,) [m/s]."""
    outer_change: Floats
    """Change of velocity over the last step, by which the next one's mean is predicted, shape (2,) [m/s]."""
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
    """Energy account since the start, shape (ACCOUNTS,) [J]."""


def empty_state(rows: int, rollers: int) -> State:
    """Return a state of zeros for ``rows`` rows of ``rollers`` rollers."""
    two, cage, body, roller, land = (2,), (rows, 3), (rows, rollers, 3), (rows, rollers), (rows,)
    shapes = [two] * 6 + [cage] * 3 + [(rows, rollers, 2), body, body] + [roller] * 14 + [land] * 3 + [two, two, (3,), (ACCOUNTS,)]
    return State._make(np.zeros(shape) for shape in shapes)

"""The state of the bearing, its one place: arrays that the time loop changes in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.core.payload import Floats


class State(NamedTuple):
    """Positions, velocities and contact memory; SI units, X right, Y up, counter-clockwise positive."""

    outer_position: Floats
    """Centre of the outer ring, shape (2,) [m]."""
    outer_velocity: Floats
    """Shape (2,) [m/s]."""
    inner_position: Floats
    """Centre of the inner ring, shape (2,) [m]."""
    inner_velocity: Floats
    """Shape (2,) [m/s]."""
    cage_position: Floats
    """Centre X, Y [m] and angle [rad] of each cage, shape (rows, 3)."""
    cage_velocity: Floats
    """Shape (rows, 3) [m/s, m/s, rad/s]."""
    spin_angle: Floats
    """Absolute rotation of each roller, shape (rows, rollers) [rad]."""
    spin: Floats
    """Absolute spin of each roller [rad/s]; like all that follow, shape (rows, rollers)."""
    inner_bristle: Floats
    """Bristle deflection at the inner raceway [m]."""
    outer_bristle: Floats
    inner_force: Floats
    """Normal force at the inner raceway over the last step [N]."""
    outer_force: Floats
    inner_friction: Floats
    """Friction force at the inner raceway over the last step [N]."""
    outer_friction: Floats
    inner_slip: Floats
    """Slip s_I at the inner raceway over the last step [m/s]; of open contacts too when observed."""
    outer_slip: Floats
    shaft: Floats
    """Angle [rad] and speed [rad/s] of the inner ring, shape (2,)."""
    load: Floats
    """Force on the inner ring, shape (2,) [N]."""
    target: Floats
    """Commanded speed [rad/s] and load in X and Y [N], shape (3,)."""

    @property
    def degrees_of_freedom(self) -> int:
        """Free coordinates: two rings and the cages in the plane, the cages' rotation, the rollers' spin [-]."""
        return 4 + self.cage_position.size + self.spin.size


def empty_state(rows: int, rollers: int) -> State:
    """Return a state of zeros for ``rows`` rows of ``rollers`` rollers."""
    two, cage, roller = (2,), (rows, 3), (rows, rollers)
    shapes = [two] * 4 + [cage] * 2 + [roller] * 10 + [two, two, (3,)]
    return State._make(np.zeros(shape) for shape in shapes)

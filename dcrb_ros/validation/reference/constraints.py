"""The constraints Phi(q, t) = 0 (Eqs. 33, 34 and 36 of Fan et al. 2025).

In this order: the housing is fixed to the ground (3), the outer ring does not rotate (1), the rotation of the inner ring is
prescribed (1), and the centre of every pinned roller is the centre of its pocket (2 each).
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.validation.reference.bodies import ANGLE, CAGE, HOUSING, INNER_RING, OUTER_RING, RING_CONSTRAINTS, Bodies, pocket_directions

GROUND, STAND, DRIVE, PINS = slice(0, 3), 3, 4, RING_CONSTRAINTS


class Constraints:
    """Constraints of a bearing whose shaft rotates at ``speed`` [rad/s].

    ``azimuth`` contains the azimuths of the pockets at cage angle zero, shape (rows, rollers) [rad]; positions and velocities have
    the shape (bodies, 3).
    """

    def __init__(self, bodies: Bodies, pitch_radius: float, azimuth: Floats, speed: float) -> None:
        self.speed = speed
        self._pitch_radius = pitch_radius
        self._roller = bodies.roller_bodies[bodies.pinned]
        self._cage = CAGE + np.nonzero(bodies.pinned)[0]
        self._azimuth = azimuth[bodies.pinned]
        self._x = PINS + 2 * np.arange(len(self._roller))
        self._constant = self._constant_jacobian(bodies)

    def _constant_jacobian(self, bodies: Bodies) -> Floats:
        jacobian = np.zeros((PINS + 2 * len(self._cage), bodies.count, 3))
        jacobian[GROUND, HOUSING] = np.eye(3)
        jacobian[STAND, OUTER_RING, ANGLE] = jacobian[DRIVE, INNER_RING, ANGLE] = 1.0
        for axis in range(2):
            jacobian[self._x + axis, self._roller, axis] = 1.0
            jacobian[self._x + axis, self._cage, axis] = -1.0
        return jacobian

    def _arms(self, position: Floats) -> tuple[Floats, Floats]:
        """Return the vector from the cage's centre to each pin, and its derivative by the cage's angle, shape (pins, 2) [m]."""
        radial, tangent = pocket_directions(self._azimuth + position[self._cage, ANGLE])
        return self._pitch_radius * radial, self._pitch_radius * tangent

    def values(self, position: Floats, time: float) -> Floats:
        """Return Phi, shape (constraints,) [m or rad]."""
        pins = position[self._roller, :ANGLE] - position[self._cage, :ANGLE] - self._arms(position)[0]
        turn = position[OUTER_RING, ANGLE], position[INNER_RING, ANGLE] - self.speed * time
        return np.asarray(np.concatenate([position[HOUSING], turn, pins.ravel()]))

    def jacobian(self, position: Floats) -> Floats:
        """Return Phi_q, shape (constraints, coordinates)."""
        jacobian = self._constant.copy()
        lever = self._arms(position)[1]
        for axis in range(2):
            jacobian[self._x + axis, self._cage, ANGLE] = -lever[:, axis]
        return np.asarray(jacobian.reshape(len(jacobian), -1))

    def rates(self, jacobian: Floats, velocity: Floats) -> Floats:
        """Return dPhi/dt = Phi_q q' + Phi_t, shape (constraints,) [m/s or rad/s]."""
        rates: Floats = jacobian @ velocity.ravel()
        rates[DRIVE] -= self.speed
        return rates

    def gamma(self, position: Floats, velocity: Floats) -> Floats:
        """Return gamma of Eq. 33, the centripetal acceleration of the pins, shape (constraints,) [m/s^2 or rad/s^2]."""
        gamma = np.zeros(len(self._constant))
        arms = self._arms(position)[0]
        gamma[PINS:] = (-(velocity[self._cage, ANGLE] ** 2)[:, None] * arms).ravel()
        return gamma

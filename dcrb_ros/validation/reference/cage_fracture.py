"""Contacts of the rollers beside a broken cage bar, with each other and with their intact bars (Eqs. 18 to 24 of Fan et al. 2025).

The normal direction at a bar is the pocket's circumferential direction tau, and friction is radial.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import pocket_azimuths
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.validation.reference.bodies import ANGLE, CAGE, Bodies, Indices, pocket_directions
from dcrb_ros.validation.reference.laws import impact_loss, johnson, pereira, stribeck, with_loss
from dcrb_ros.validation.reference.raceways import ContactForces, ContactKinematics, dot, perpendicular, with_friction


def add_at(force: Floats, bodies: Indices, push: Floats, torque: Floats) -> None:
    """Add forces of shape (n, 2) [N] and torques of shape (n,) [N m] to ``bodies``, in which an index may occur twice."""
    np.add.at(force, bodies, np.column_stack([push, torque]))


class RollerPairs:
    """The two rollers beside each broken bar (Eqs. 18 and 19); pairs in the order of ``bodies.broken_bars``."""

    def __init__(self, configuration: Configuration, bodies: Bodies) -> None:
        self._configuration = configuration
        rows, bars = np.array(bodies.broken_bars, np.int64).reshape(-1, 2).T
        self._behind: Indices = bodies.roller_bodies[rows, bars]
        self._ahead: Indices = bodies.roller_bodies[rows, (bars + 1) % bodies.rollers_per_row]
        self.count = len(self._ahead)
        """Number of pairs [-]."""

    def kinematics(self, position: Floats, velocity: Floats) -> ContactKinematics:
        """Return the position and motion of the roller ahead relative to the one behind."""
        radius = self._configuration.bearing.roller_radius
        arm = position[self._ahead, :ANGLE] - position[self._behind, :ANGLE]
        distance = np.hypot(arm[:, 0], arm[:, 1])
        n = arm / distance[:, None]
        relative = velocity[self._ahead, :ANGLE] - velocity[self._behind, :ANGLE]
        spins = velocity[self._ahead, ANGLE] + velocity[self._behind, ANGLE]
        return ContactKinematics(n, 2.0 * radius - distance, -dot(relative, n), dot(relative, perpendicular(n)) - radius * spins)

    def act(self, position: Floats, velocity: Floats, bristle: Floats, force: Floats) -> ContactForces:
        """Add the contacts' forces and torques to ``force``, shape (bodies, 3) [N, N, N m], and return the contacts."""
        c, radius = self._configuration, self._configuration.bearing.roller_radius
        n, penetration, rate, slip = self.kinematics(position, velocity)
        elastic, stiffness = johnson(penetration, c.bearing.effective_modulus * c.bearing.roller_length, 2.0 * radius)
        normal = with_loss(elastic, stiffness, c.contact.loss_time, rate)
        contacts = with_friction(c, penetration, normal, bristle, slip, stribeck(slip, c.friction))
        push = normal[:, None] * n - contacts.friction[:, None] * perpendicular(n)
        for rollers, sign in ((self._ahead, 1.0), (self._behind, -1.0)):
            add_at(force, rollers, sign * push, radius * contacts.friction)
        return contacts


class BarKinematics(NamedTuple):
    """Position and motion of freed rollers relative to their intact bars; shape (bars,) unless stated otherwise."""

    radial: Floats
    """Outward direction n of the pocket, shape (bars, 2)."""
    circumferential: Floats
    """Circumferential direction tau of the pocket, shape (bars, 2)."""
    lever: Floats
    """Vector from the centre of the cage to the contact, shape (bars, 2) [m]."""
    penetration: Floats
    """Penetration delta = side e.tau - c_p, Eqs. 20 and 21 [m]."""
    rate: Floats
    """d(delta)/dt [m/s]."""
    slip: Floats
    """Radial slip of the roller's surface relative to the bar [m/s]."""


class IntactBars:
    """The intact bars beside freed rollers (Eqs. 20 to 22); ``side`` is +1 for a bar ahead of its roller, -1 behind."""

    def __init__(self, configuration: Configuration, bodies: Bodies) -> None:
        self._configuration, self._cage = configuration, configuration.cage
        intact = np.stack([bodies.bar_intact, np.roll(bodies.bar_intact, 1, axis=1)])
        sides, rows, rollers = np.nonzero(intact & ~bodies.pinned)
        self.side: Floats = np.where(sides == 0, 1.0, -1.0)
        self.cage: Indices = CAGE + rows
        self.roller: Indices = bodies.roller_bodies[rows, rollers]
        self._azimuth = pocket_azimuths(configuration.bearing)[rows, rollers]
        self.impact_speed: Floats = np.zeros(len(sides))
        """Rate of penetration when each contact closed [m/s]; zero while it is open."""
        self.count = len(sides)
        """Number of bars that a freed roller can touch [-]."""

    def kinematics(self, position: Floats, velocity: Floats) -> BarKinematics:
        """Return the position and motion of the rollers relative to their bars.

        The velocity is taken relative to the cage at the contact point, so that its component along tau is the rate of e.tau,
        including the rotation of tau.
        """
        bearing, cage = self._configuration.bearing, velocity[self.cage]
        n, tau = pocket_directions(self._azimuth + position[self.cage, ANGLE])
        arm = position[self.roller, :ANGLE] - position[self.cage, :ANGLE]
        offset = arm - bearing.pitch_radius * n
        lever = arm + (self.side * bearing.roller_radius)[:, None] * tau
        relative = velocity[self.roller, :ANGLE] - cage[:, :ANGLE] - cage[:, ANGLE, None] * perpendicular(lever)
        return BarKinematics(
            n,
            tau,
            lever,
            self.side * dot(offset, tau) - self._cage.pocket_clearance,
            self.side * dot(relative, tau),
            dot(relative, n) - self.side * bearing.roller_radius * velocity[self.roller, ANGLE],
        )

    def latch(self, position: Floats, velocity: Floats) -> None:
        """Store the impact speed of every contact that has closed since the last call; clear it for open contacts."""
        kinematics = self.kinematics(position, velocity)
        first = np.where(self.impact_speed > 0.0, self.impact_speed, np.maximum(kinematics.rate, np.finfo(float).tiny))
        self.impact_speed = np.where(kinematics.penetration > 0.0, first, 0.0)

    def act(self, position: Floats, velocity: Floats, bristle: Floats, force: Floats) -> ContactForces:
        """Add the contacts' forces and torques to ``force``, shape (bodies, 3) [N, N, N m], and return the contacts."""
        bearing = self._configuration.bearing
        n, tau, lever, penetration, rate, slip = self.kinematics(position, velocity)
        impact_speed = np.where(self.impact_speed > 0.0, self.impact_speed, rate)
        normal = pereira(penetration, self._cage.pocket_clearance, bearing.roller_length, bearing.effective_modulus)
        normal *= impact_loss(rate, impact_speed, self._cage.restitution)
        steady = np.full_like(slip, self._cage.friction_coefficient)
        contacts = with_friction(self._configuration, penetration, normal, bristle, slip, steady)
        push = -(self.side * contacts.normal)[:, None] * tau - contacts.friction[:, None] * n
        add_at(force, self.roller, push, self.side * bearing.roller_radius * contacts.friction)
        add_at(force, self.cage, -push, -dot(perpendicular(lever), push))
        return contacts

"""Contacts of the rollers with the raceways and their defects (Eqs. 1 to 17 of Fan et al. 2025, with u_R - u_ring throughout)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.faults.raceway_defect import InnerRacewayDefect, OuterRacewayDefect, RacewayDefect
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.validation.reference.bodies import ANGLE, INNER_RING, OUTER_RING, Bodies
from dcrb_ros.validation.reference.laws import johnson, lugre, relaxation_rate, stribeck, with_loss

BoolArray = npt.NDArray[np.bool_]

NEAR = 2e-6
"""Gap below which a contact may close within a step of 1 us: 2 m/s of approach [m]."""


class ContactForces(NamedTuple):
    """Forces and bristle rates of the contacts of one kind; all arrays have the shape of the contacts."""

    normal: Floats
    """Normal force [N]."""
    friction: Floats
    """Friction force [N]."""
    bristle_rate: Floats
    """Rate of the bristle deflection [m/s], zero in an open contact."""
    closed: BoolArray
    """Whether the surfaces touch; the bristle of an open contact is reset."""
    relaxation: Floats
    """Rate at which the bristle approaches its steady deflection [1/s], zero in a contact wider open than `NEAR`."""


class ContactKinematics(NamedTuple):
    """Position and motion of rollers relative to a raceway or another roller; all arrays have the shape of the contacts."""

    normal: Floats
    """Unit vector n from the centre of the ring or of the other roller to the roller, shape (..., 2)."""
    penetration: Floats
    """delta [m]."""
    rate: Floats
    """d(delta)/dt [m/s]."""
    slip: Floats
    """Slip of the roller's surface relative to the other surface [m/s]."""


def with_friction(
    configuration: Configuration, penetration: Floats, normal: Floats, bristle: Floats, slip: Floats, steady: Floats
) -> ContactForces:
    """Return the contact forces for normal forces [N]; ``steady`` is the friction coefficient in steady sliding, g [-]."""
    coefficient, rate = lugre(bristle, slip, steady, configuration.friction)
    closed = penetration > 0.0
    relaxation = np.where(penetration > -NEAR, relaxation_rate(slip, steady, configuration.friction), 0.0)
    return ContactForces(normal, coefficient * normal, np.where(closed, rate, 0.0), closed, relaxation)


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar products of plane vectors of shape (..., 2)."""
    return np.asarray((a * b).sum(axis=-1))


def perpendicular(vector: Floats) -> Floats:
    """Return e_z x vector, the vectors rotated by a quarter turn counter-clockwise, shape (..., 2)."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


@dataclass(frozen=True)
class Raceway:
    """A raceway and its defects; ``side`` is +1 if the rollers roll on its outside (inner ring), -1 if on its inside."""

    configuration: Configuration
    bodies: Bodies
    ring: int
    side: int
    radius: float
    defects: tuple[RacewayDefect, ...]

    @property
    def reach(self) -> float:
        """Distance between the centres of ring and roller at first contact, which is also dR of Eq. 4: r_I + r_R or r_O - r_R [m]."""
        return self.radius + self.side * self.configuration.bearing.roller_radius

    def notch(self, edge: Floats, depth: float) -> tuple[Floats, Floats]:
        """Return how deep a roller sinks into a defect [m] and the slope of that depth [m/rad], Eqs. 8, 9, 14 and 15.

        ``edge`` is the angle from the nearer edge of the defect, positive inside [rad].
        """
        radius, roller = self.radius, self.configuration.bearing.roller_radius
        sine, cosine = np.sin(np.maximum(edge, 0.0)), np.cos(np.maximum(edge, 0.0))
        root = np.sqrt(roller**2 - (radius * sine) ** 2)
        sink = self.side * radius * (1.0 - cosine) + roller - root
        slope = self.side * radius * sine + radius**2 * sine * cosine / root
        return np.minimum(sink, depth), np.where(sink < depth, slope, 0.0)

    def sink(self, azimuth: Floats, azimuth_rate: Floats, angle: float) -> tuple[Floats, Floats]:
        """Return the depth of the defects under each roller [m] and its rate [m/s], shape (rows, rollers).

        ``azimuth_rate`` is the rate of the azimuth relative to the ring [rad/s], ``angle`` the rotation of the ring [rad].
        """
        deepest, rate = np.zeros_like(azimuth), np.zeros_like(azimuth)
        for defect in self.defects:
            offset = np.remainder(azimuth - defect.azimuth - angle + np.pi, 2.0 * np.pi) - np.pi
            depth, slope = self.notch(0.5 * defect.width / self.radius - np.abs(offset), defect.depth)
            if defect.row:
                depth[np.arange(len(depth)) != defect.row - 1] = 0.0
            rate = np.where(depth > deepest, -np.sign(offset) * slope * azimuth_rate, rate)
            deepest = np.maximum(depth, deepest)
        return deepest, rate

    def kinematics(self, position: Floats, velocity: Floats) -> ContactKinematics:
        """Return the position and motion of the rollers relative to the raceway."""
        roller, ring = self.bodies.rollers(velocity), velocity[self.ring]
        arm = self.bodies.rollers(position)[..., :ANGLE] - position[self.ring, :ANGLE]
        distance = np.hypot(arm[..., 0], arm[..., 1])
        n = arm / distance[..., None]
        relative = roller[..., :ANGLE] - ring[:ANGLE]
        passing = dot(relative, perpendicular(n))
        azimuth = np.arctan2(n[..., 0], -n[..., 1])
        depth, depth_rate = self.sink(azimuth, passing / distance - ring[ANGLE], position[self.ring, ANGLE])
        return ContactKinematics(
            n,
            self.side * (self.reach - distance) - depth,
            -self.side * dot(relative, n) - depth_rate,
            passing - self.side * self.configuration.bearing.roller_radius * roller[..., ANGLE] - self.radius * ring[ANGLE],
        )

    def act(self, position: Floats, velocity: Floats, bristle: Floats, force: Floats) -> ContactForces:
        """Add the contacts' forces and torques to ``force``, shape (bodies, 3) [N, N, N m], and return the contacts."""
        c = self.configuration
        n, penetration, rate, slip = self.kinematics(position, velocity)
        elastic, stiffness = johnson(penetration, c.bearing.effective_modulus * c.bearing.roller_length, self.reach)
        normal = with_loss(elastic, stiffness, c.contact.loss_time, rate)
        contacts = with_friction(c, penetration, normal, bristle, slip, stribeck(slip, c.friction))
        push = self.side * normal[..., None] * n - contacts.friction[..., None] * perpendicular(n)
        on_rollers = self.bodies.rollers(force)
        on_rollers[..., :ANGLE] += push
        on_rollers[..., ANGLE] += self.side * c.bearing.roller_radius * contacts.friction
        force[self.ring, :ANGLE] -= push.sum(axis=(0, 1))
        force[self.ring, ANGLE] += self.radius * contacts.friction.sum()
        return contacts


def raceways(configuration: Configuration, bodies: Bodies) -> tuple[Raceway, Raceway]:
    """Return the raceways of the inner and the outer ring."""
    bearing = configuration.bearing
    inner, outer = (tuple(configuration.faults.of_kind(kind)) for kind in (InnerRacewayDefect, OuterRacewayDefect))
    return (
        Raceway(configuration, bodies, INNER_RING, 1, bearing.inner_raceway_radius, inner),
        Raceway(configuration, bodies, OUTER_RING, -1, bearing.outer_raceway_radius, outer),
    )

"""Rollers on the raceways, smooth or with notches (Eqs. 1 to 17 of Fan et al. 2025, with u_R - u_ring throughout)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.faults.raceway_defect import InnerRacewayDefect, OuterRacewayDefect, RacewayDefect
from dcrb_ros.reference.bodies import ANGLE, INNER_RING, OUTER_RING, Bodies
from dcrb_ros.reference.laws import johnson, lugre, stribeck, with_loss
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

BoolArray = npt.NDArray[np.bool_]


class Contacts(NamedTuple):
    """What one kind of contacts does; all of the contacts' shape."""

    normal: Floats
    """Normal force [N]."""
    friction: Floats
    """Friction force [N]."""
    bristle_rate: Floats
    """Rate of the bristle [m/s], zero in an open contact."""
    closed: BoolArray
    """Whether the surfaces touch: an open contact forgets its bristle."""


class Approach(NamedTuple):
    """How rollers stand and move against a raceway or another roller; all of the contacts' shape."""

    normal: Floats
    """Unit vector n to the roller from the ring or the other roller, shape (..., 2)."""
    penetration: Floats
    """delta [m]."""
    rate: Floats
    """d(delta)/dt [m/s]."""
    slip: Floats
    """Slip of the roller's surface over the other one [m/s]."""


def rub(configuration: Configuration, penetration: Floats, normal: Floats, bristle: Floats, slip: Floats, steady: Floats) -> Contacts:
    """Return contacts of a normal force [N] with their friction, ``steady`` being g [-]."""
    coefficient, rate = lugre(bristle, slip, steady, configuration.friction)
    closed = penetration > 0.0
    return Contacts(normal, coefficient * normal, np.where(closed, rate, 0.0), closed)


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar products of plane vectors, shape (..., 2)."""
    product: Floats = (a * b).sum(axis=-1)
    return product


def turned(vector: Floats) -> Floats:
    """Return e_z x vector, a quarter turn counter-clockwise, shape (..., 2)."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


@dataclass(frozen=True)
class Raceway:
    """A raceway and its defects; ``side`` is +1 where the rollers roll outside of it (inner ring), -1 inside."""

    configuration: Configuration
    bodies: Bodies
    ring: int
    side: int
    radius: float
    defects: tuple[RacewayDefect, ...]

    @property
    def reach(self) -> float:
        """Distance from ring to roller at first touch, also dR of Eq. 4: r_I + r_R or r_O - r_R [m]."""
        return self.radius + self.side * self.configuration.bearing.roller_radius

    def notch(self, edge: Floats, depth: float) -> tuple[Floats, Floats]:
        """Return the depth [m] at angles inside a notch's nearer edge [rad] and its slope [m/rad], Eqs. 8, 9, 13 to 15."""
        radius, roller = self.radius, self.configuration.bearing.roller_radius
        sine, cosine = np.sin(np.maximum(edge, 0.0)), np.cos(np.maximum(edge, 0.0))
        root = np.sqrt(roller**2 - (radius * sine) ** 2)
        sink = self.side * radius * (1.0 - cosine) + roller - root
        slope = self.side * radius * sine + radius**2 * sine * cosine / root
        return np.minimum(sink, depth), np.where(sink < depth, slope, 0.0)

    def sink(self, azimuth: Floats, azimuth_rate: Floats, angle: float) -> tuple[Floats, Floats]:
        """Return how deep the raceway lies under each roller [m] and the rate of that [m/s], shape (rows, rollers).

        ``azimuth_rate`` [rad/s] is that of the contact over the ring, ``angle`` the ring's rotation [rad].
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

    def approach(self, position: Floats, velocity: Floats) -> Approach:
        """Return how the rollers stand and move against the raceway."""
        roller, ring = self.bodies.rollers(velocity), velocity[self.ring]
        arm = self.bodies.rollers(position)[..., :ANGLE] - position[self.ring, :ANGLE]
        distance = np.hypot(arm[..., 0], arm[..., 1])
        n = arm / distance[..., None]
        relative = roller[..., :ANGLE] - ring[:ANGLE]
        passing = dot(relative, turned(n))
        azimuth = np.arctan2(n[..., 0], -n[..., 1])
        depth, depth_rate = self.sink(azimuth, passing / distance - ring[ANGLE], position[self.ring, ANGLE])
        return Approach(
            n,
            self.side * (self.reach - distance) - depth,
            -self.side * dot(relative, n) - depth_rate,
            passing - self.side * self.configuration.bearing.roller_radius * roller[..., ANGLE] - self.radius * ring[ANGLE],
        )

    def act(self, position: Floats, velocity: Floats, bristle: Floats, force: Floats) -> Contacts:
        """Add the contacts' forces and torques to ``force``, shape (bodies, 3) [N, N, N m], and return the contacts."""
        c = self.configuration
        n, penetration, rate, slip = self.approach(position, velocity)
        elastic, stiffness = johnson(penetration, c.bearing.effective_modulus * c.bearing.roller_length, self.reach)
        normal = with_loss(elastic, stiffness, c.contact.loss_time, rate)
        contacts = rub(c, penetration, normal, bristle, slip, stribeck(slip, c.friction))
        push = self.side * normal[..., None] * n - contacts.friction[..., None] * turned(n)
        on_rollers = self.bodies.rollers(force)
        on_rollers[..., :ANGLE] += push
        on_rollers[..., ANGLE] += self.side * c.bearing.roller_radius * contacts.friction
        force[self.ring, :ANGLE] -= push.sum(axis=(0, 1))
        force[self.ring, ANGLE] += self.radius * contacts.friction.sum()
        return contacts


def raceways(configuration: Configuration, bodies: Bodies) -> tuple[Raceway, Raceway]:
    """Return the raceways of inner and outer ring."""
    bearing = configuration.bearing
    inner, outer = (tuple(configuration.faults.of_kind(kind)) for kind in (InnerRacewayDefect, OuterRacewayDefect))
    return (
        Raceway(configuration, bodies, INNER_RING, 1, bearing.inner_raceway_radius, inner),
        Raceway(configuration, bodies, OUTER_RING, -1, bearing.outer_raceway_radius, outer),
    )

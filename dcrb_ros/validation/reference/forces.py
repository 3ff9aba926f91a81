"""The generalised external forces Q_e (Eq. 37 of Fan et al. 2025): weight, load, housing and contacts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.validation.reference.bodies import ANGLE, HOUSING, INNER_RING, OUTER_RING, Bodies
from dcrb_ros.validation.reference.cage_fracture import IntactBars, RollerPairs
from dcrb_ros.validation.reference.raceways import raceways

X_Y = slice(0, ANGLE)


class ExternalForces(NamedTuple):
    """The external forces and the rates of the bristles at one instant."""

    force: Floats
    """Q_e, shape (bodies, 3) [N, N, N m]."""
    bristle_rate: Floats
    """Rates of the bristle deflections, shape (contacts,) [m/s]."""
    closed: Floats
    """1 for closed contacts, 0 for open ones, shape (contacts,) [-]."""
    inner_normal: Floats
    """Normal forces at the inner raceway, shape (rows, rollers) [N]."""
    inner_ring_force: Floats
    """Force of the rollers on the inner ring in X and Y, shape (2,) [N]."""
    relaxation: float
    """Largest rate at which a bristle approaches its steady deflection [1/s]."""


class Forces:
    """All forces on the bodies except those of the constraints."""

    def __init__(self, configuration: Configuration, bodies: Bodies, bars: IntactBars) -> None:
        self._configuration = configuration
        operating = configuration.operating
        self._steady = -operating.gravity * bodies.masses(configuration.bearing) * (0.0, 1.0, 0.0)
        self._steady[INNER_RING, X_Y] += operating.lateral_load, -operating.load
        self._inner, self._outer = raceways(configuration, bodies)
        self._pairs, self._bars = RollerPairs(configuration, bodies), bars
        row_shape = (bodies.rows, bodies.rollers_per_row)
        self._shapes = [row_shape, row_shape, (self._pairs.count,), (bars.count,)]
        self.contact_count = sum(int(np.prod(shape)) for shape in self._shapes)

    def _add_housing(self, position: Floats, velocity: Floats, force: Floats) -> None:
        housing = self._configuration.housing
        stretch = position[OUTER_RING, X_Y] - position[HOUSING, X_Y]
        pull = housing.stiffness * stretch + housing.damping * (velocity[OUTER_RING, X_Y] - velocity[HOUSING, X_Y])
        force[OUTER_RING, X_Y] -= pull
        force[HOUSING, X_Y] += pull

    def at(self, position: Floats, velocity: Floats, bristle: Floats) -> ExternalForces:
        """Return the forces at positions and velocities of shape (bodies, 3) and bristle deflections of shape (contacts,) [m].

        The bristles are ordered by contact: inner raceway, outer raceway, roller pairs, bars.
        """
        force = self._steady.copy()
        self._add_housing(position, velocity, force)
        ends = np.cumsum([int(np.prod(shape)) for shape in self._shapes])[:-1]
        bristles = [part.reshape(shape) for part, shape in zip(np.split(bristle, ends), self._shapes, strict=True)]
        before = force[INNER_RING, X_Y].copy()
        inner = self._inner.act(position, velocity, bristles[0], force)
        ring_force = force[INNER_RING, X_Y] - before
        kinds = [inner, self._outer.act(position, velocity, bristles[1], force)]
        if self._pairs.count:
            kinds.append(self._pairs.act(position, velocity, bristles[2], force))
            kinds.append(self._bars.act(position, velocity, bristles[3], force))
        rates = np.concatenate([kind.bristle_rate.ravel() for kind in kinds])
        closed = np.concatenate([kind.closed.ravel() for kind in kinds]).astype(np.float64)
        relaxation = max(float(kind.relaxation.max(initial=0.0)) for kind in kinds)
        return ExternalForces(force, rates, closed, inner.normal, ring_force, relaxation)

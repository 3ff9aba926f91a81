"""The bodies: their coordinates (Eq. 31 of Fan et al. 2025), masses and degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.parameters import Bearing

Indices = npt.NDArray[np.int64]

HOUSING, OUTER_RING, INNER_RING, CAGE = range(4)
"""Indices of the bodies; from CAGE on there is one cage per row, then the rollers row by row."""

ANGLE = 2
"""Index of the absolute rotation [rad] in the coordinates of a body, after X and Y [m]."""

RING_CONSTRAINTS = 5
"""Constraints of the housing (3), of the rotation of the outer ring (1) and of the inner ring (1) [-]."""

INNER_RING_INERTIA, OUTER_RING_INERTIA = 3.82e-2, 0.166
"""Table 1 [kg m^2]. The rotations of the rings are prescribed, so these values do not affect the motion."""


def pocket_directions(azimuth: Floats) -> tuple[Floats, Floats]:
    """Return the radial direction n and the circumferential direction tau at an azimuth [rad], shape (..., 2) each."""
    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    return np.stack([sine, -cosine], axis=-1), np.stack([cosine, sine], axis=-1)


@dataclass(frozen=True)
class Bodies:
    """Index map of the coordinates, which are stored in arrays of shape (bodies, 3) [m, m, rad].

    ``broken_bars`` contains pairs of row and bar, counted from zero; bar k is between the rollers k and k + 1, the last bar between
    the last roller and roller 0.
    """

    rows: int
    rollers_per_row: int
    broken_bars: tuple[tuple[int, int], ...] = ()

    @property
    def count(self) -> int:
        """Number of bodies: housing, two rings, the cages and the rollers [-]."""
        return CAGE + self.rows * (1 + self.rollers_per_row)

    @property
    def degrees_of_freedom(self) -> int:
        """Coordinates minus constraints [-]: 10 + nr healthy, 14 + nr with a broken bar, 18 + nr with one in each row."""
        return 3 * self.count - RING_CONSTRAINTS - 2 * int(self.pinned.sum())

    @cached_property
    def bar_intact(self) -> npt.NDArray[np.bool_]:
        """Whether the bar ahead of each roller is intact, shape (rows, rollers)."""
        intact = np.ones((self.rows, self.rollers_per_row), np.bool_)
        for row, bar in self.broken_bars:
            intact[row, bar] = False
        return intact

    @cached_property
    def pinned(self) -> npt.NDArray[np.bool_]:
        """Whether each roller is pinned to its pocket: both bars beside it are intact, shape (rows, rollers)."""
        return np.asarray(self.bar_intact & np.roll(self.bar_intact, 1, axis=1))

    @cached_property
    def roller_bodies(self) -> Indices:
        """Body index of each roller, shape (rows, rollers)."""
        return CAGE + self.rows + np.arange(self.rows * self.rollers_per_row).reshape(self.rows, -1)

    def cages(self, coordinates: Floats) -> Floats:
        """Return the cages' part of ``coordinates``, a view of shape (rows, 3)."""
        return coordinates[CAGE : CAGE + self.rows]

    def rollers(self, coordinates: Floats) -> Floats:
        """Return the rollers' part of ``coordinates``, a view of shape (rows, rollers, 3)."""
        return coordinates[CAGE + self.rows :].reshape(self.rows, self.rollers_per_row, 3)

    def masses(self, bearing: Bearing) -> Floats:
        """Return the diagonal of the mass matrix M of Eq. 32, shape (bodies, 3) [kg, kg, kg m^2]."""
        mass = np.empty((self.count, 3))
        # The housing is fixed to the ground, so its mass is arbitrary.
        mass[HOUSING] = mass[OUTER_RING] = bearing.outer_ring_mass, bearing.outer_ring_mass, OUTER_RING_INERTIA
        mass[INNER_RING] = bearing.inner_ring_mass, bearing.inner_ring_mass, INNER_RING_INERTIA
        self.cages(mass)[:] = bearing.cage_mass, bearing.cage_mass, bearing.cage_inertia
        self.rollers(mass)[:] = bearing.roller_mass, bearing.roller_mass, bearing.roller_inertia
        return mass

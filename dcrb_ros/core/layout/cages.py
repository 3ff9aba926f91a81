"""The motion of the cages for loops over rollers: read once for both rows, chosen for each roller by its row."""

from __future__ import annotations

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import CAGE

Triple = tuple[float, float, float]
"""Components of a cage's position or velocity in X, in Y, and in rotation."""
OfCages = tuple[Triple, Triple]
"""The same of the cages of the first and of the second row."""


@kernel
def of_cages(bodies: Floats) -> OfCages:
    """Return the cages' part of positions or velocities of all bodies, shape (2 + rows, 3); a single cage counts for both rows."""
    last = bodies.shape[0] - 1
    return (bodies[CAGE, 0], bodies[CAGE, 1], bodies[CAGE, 2]), (bodies[last, 0], bodies[last, 1], bodies[last, 2])


@kernel
def headings_of(heading: Floats) -> OfCages:
    """Return cosine and sine of both cages' angles from an array of the shape (rows, 2), and zero [-]."""
    last = heading.shape[0] - 1
    return (heading[0, 0], heading[0, 1], 0.0), (heading[last, 0], heading[last, 1], 0.0)


@kernel
def of_row(cages: OfCages, second_row: float) -> Triple:
    """Return the components of a roller's cage; ``second_row`` is 1 in the second row and 0 in the first."""
    first, second, in_second = cages[0], cages[1], second_row > 0.0
    return second[0] if in_second else first[0], second[1] if in_second else first[1], second[2] if in_second else first[2]

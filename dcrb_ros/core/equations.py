"""The linear system of one velocity update: assembled roller by roller, solved by elimination row by row.

Unknown are the mean velocities over the step. The spin of a roller is eliminated as the roller is added, the cage of a
row after the row's last roller; the two rings are left. A row's block has the unknowns of `OUTER`, `INNER` and `CAGE`:
the rings' and the cage's velocities in X and Y and the cage's rim speed r_M omega_C, all in [m/s].
"""

from __future__ import annotations

from numba import njit

from dcrb_ros.core.payload import Floats

OUTER, INNER, CAGE = 0, 2, 4
UNKNOWNS = 7
WIDTH = 8
"""Columns of a block: the unknowns and, last, the right-hand side."""


@njit(cache=True, forceinline=True)
def clear(block: Floats) -> None:
    """Set a block to zero."""
    for i in range(UNKNOWNS):
        for j in range(WIDTH):
            block[i, j] = 0.0


@njit(cache=True, forceinline=True)
def fill_direction(row: Floats, ring: int, x: float, y: float, rim: float) -> None:
    """Write the velocity of a roller against ring ``ring`` along (x, y) as a row over the unknowns.

    ``rim`` is the share of the cage's rim speed: the direction's component along the pocket's tangent.
    """
    for j in range(WIDTH):
        row[j] = 0.0
    row[ring], row[ring + 1] = -x, -y
    row[CAGE], row[CAGE + 1], row[CAGE + 2] = x, y, rim


@njit(cache=True, forceinline=True)
def along(row: Floats, velocity: Floats) -> float:
    """Return the velocity [m/s] that a direction row picks from the unknowns."""
    total = 0.0
    for j in range(UNKNOWNS):
        total += row[j] * velocity[j]
    return total


@njit(cache=True, forceinline=True)
def add_contacts(
    block: Floats,
    slip_i: Floats,
    slip_o: Floats,
    normal_i: Floats,
    normal_o: Floats,
    weight_i: float,
    weight_o: float,
    weight_io: float,
    weight_ni: float,
    weight_no: float,
    push_i: float,
    push_o: float,
    push_ni: float,
    push_no: float,
) -> None:
    """Add both contacts of a roller: the weights to the matrix, the pushes to the right-hand side."""
    for i in range(UNKNOWNS):
        si, so = slip_i[i], slip_o[i]
        a = weight_i * si + weight_io * so
        b = weight_io * si + weight_o * so
        c = weight_ni * normal_i[i]
        d = weight_no * normal_o[i]
        for j in range(UNKNOWNS):
            block[i, j] += a * slip_i[j] + b * slip_o[j] + c * normal_i[j] + d * normal_o[j]
        block[i, UNKNOWNS] += push_i * si + push_o * so + push_ni * normal_i[i] + push_no * normal_o[i]


@njit(cache=True, forceinline=True)
def eliminate(block: Floats, first: int, count: int) -> None:
    """Eliminate the unknowns from ``count`` - 1 down to ``first``; the rows above keep the Schur complement."""
    for k in range(count - 1, first - 1, -1):
        inverse = 1.0 / block[k, k]
        for i in range(k):
            factor = block[i, k] * inverse
            for j in range(k):
                block[i, j] -= factor * block[k, j]
            block[i, UNKNOWNS] -= factor * block[k, UNKNOWNS]


@njit(cache=True, forceinline=True)
def substitute(block: Floats, first: int, count: int, velocity: Floats) -> None:
    """Solve for the unknowns from ``first`` to ``count`` - 1, those before ``first`` being known."""
    for k in range(first, count):
        rest = block[k, UNKNOWNS]
        for j in range(k):
            rest -= block[k, j] * velocity[j]
        velocity[k] = rest / block[k, k]

"""The linear system of one velocity update: collected roller by roller, solved row by row.

Unknown are the mean velocities over the step: of the outer ring and the inner ring in X and Y, and of each cage in X, Y
and at its rim (r_M omega_C), all in [m/s]. A roller's spin is eliminated when the roller is added, a cage after its last
roller; the two rings are left.

A roller passes force between cage and ring along the directions t' = (t_x, t_y, t.tau) and n' = (n_x, n_y, n.tau), where
tau is the tangent of its pocket. So a row needs three sums only: the inner contacts' tensor A = sum(w t' t'^T + v n' n'^T),
the outer contacts' tensor B, and X = sum(w_io t1' t2'^T), by which the spin couples the two; then

    cage, cage:   A + B + X + X^T      inner, cage: -(A + X)    outer, cage: -(B + X^T)
    inner, inner: A                    outer, outer: B          outer, inner: X^T     (first two components)
"""

from __future__ import annotations

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import Floats

A, B, X, PUSH_I, PUSH_O = 0, 6, 12, 21, 24
SUMS = 27
"""Length of a row's sums: A and B as xx, xy, xz, yy, yz, zz; X row by row; the pushes of inner and outer contacts."""

OUTER, INNER, CAGE = 0, 2, 4
UNKNOWNS = 7
WIDTH = 8
"""Columns of a block: the unknowns and, last, the right-hand side."""


@kernel
def add_contact(
    sums: Floats, tensor: int, push: int, nx: float, ny: float, rim_n: float, rim_t: float, weights: tuple[float, float, float, float]
) -> None:
    """Add one contact to a row's sums.

    (nx, ny) is the normal from the ring to the roller, ``rim_n`` and ``rim_t`` the components of normal and tangent along
    the pocket's tangent; ``weights`` are those of tangent and normal in the tensor and in the push.
    """
    tx, ty = -ny, nx
    weight_t, weight_n, push_t, push_n = weights
    ax, ay, az = weight_t * tx, weight_t * ty, weight_t * rim_t
    bx, by, bz = weight_n * nx, weight_n * ny, weight_n * rim_n
    sums[tensor] += ax * tx + bx * nx
    sums[tensor + 1] += ax * ty + bx * ny
    sums[tensor + 2] += ax * rim_t + bx * rim_n
    sums[tensor + 3] += ay * ty + by * ny
    sums[tensor + 4] += ay * rim_t + by * rim_n
    sums[tensor + 5] += az * rim_t + bz * rim_n
    sums[push] += push_t * tx + push_n * nx
    sums[push + 1] += push_t * ty + push_n * ny
    sums[push + 2] += push_t * rim_t + push_n * rim_n


@kernel
def add_coupling(
    sums: Floats, weight: float, inner_x: float, inner_y: float, inner_rim: float, outer_x: float, outer_y: float, outer_rim: float
) -> None:
    """Add what a roller's spin passes from the inner contact's tangent to the outer one's."""
    for k, share in ((X, weight * inner_x), (X + 3, weight * inner_y), (X + 6, weight * inner_rim)):
        sums[k] += share * outer_x
        sums[k + 1] += share * outer_y
        sums[k + 2] += share * outer_rim


@kernel
def fold_row(sums: Floats, block: Floats) -> None:
    """Add a row's sums to its block's lower triangle, which starts with the cage's inertia."""
    for i in range(3):
        for j in range(3):
            low, high = min(i, j), max(i, j)
            k = 3 * low - low * (low - 1) // 2 + high - low
            a, b = sums[A + k], sums[B + k]
            x, x_turned = sums[X + 3 * i + j], sums[X + 3 * j + i]
            if j <= i:
                block[CAGE + i, CAGE + j] += a + b + x + x_turned
            if j < 2:
                block[CAGE + i, INNER + j] = -(a + x_turned)
                block[CAGE + i, OUTER + j] = -(b + x)
                if i < 2:
                    block[INNER + i, INNER + j] = a
                    block[OUTER + i, OUTER + j] = b
                    block[INNER + i, OUTER + j] = x
        push_i, push_o = sums[PUSH_I + i], sums[PUSH_O + i]
        block[CAGE + i, UNKNOWNS] += push_i + push_o
        if i < 2:
            block[INNER + i, UNKNOWNS] = -push_i
            block[OUTER + i, UNKNOWNS] = -push_o


@kernel
def eliminate(block: Floats, first: int, count: int) -> None:
    """Eliminate the unknowns from ``count`` - 1 down to ``first``; the rows above keep the Schur complement.

    The matrix is symmetric, only its lower triangle is read and written.
    """
    for k in range(count - 1, first - 1, -1):
        inverse = 1.0 / block[k, k]
        for i in range(k):
            factor = block[k, i] * inverse
            for j in range(i + 1):
                block[i, j] -= factor * block[k, j]
            block[i, UNKNOWNS] -= factor * block[k, UNKNOWNS]


@kernel
def substitute(block: Floats, first: int, count: int, velocity: Floats) -> None:
    """Solve for the unknowns from ``first`` to ``count`` - 1, those before ``first`` being known."""
    for k in range(first, count):
        rest = block[k, UNKNOWNS]
        for j in range(k):
            rest -= block[k, j] * velocity[j]
        velocity[k] = rest / block[k, k]

"""Compiled loops over samples. They call no other kernel, and their rounding does not depend on how the samples are split."""

from __future__ import annotations

import numpy as np
from numba import njit

import dcrb_ros.core  # noqa: F401 - sets the folder of the compiled kernels
from dcrb_ros.schema.arrays import Floats, Integers


@njit(cache=True, nogil=True, error_model="numpy")
def filtered(sections: Floats, memory: Floats, samples: Floats) -> Floats:
    """Return ``samples``, shape (samples, columns), through second-order sections, shape (sections, 6), in transposed direct form II.

    ``memory``, shape (sections, 2, columns), is the state of the sections and is updated.
    """
    filtered: Floats = samples.copy()
    for i in range(filtered.shape[0]):
        for column in range(filtered.shape[1]):
            x = filtered[i, column]
            for k in range(sections.shape[0]):
                y = sections[k, 0] * x + memory[k, 0, column]
                memory[k, 0, column] = sections[k, 1] * x - sections[k, 4] * y + memory[k, 1, column]
                memory[k, 1, column] = sections[k, 2] * x - sections[k, 5] * y
                x = y
            filtered[i, column] = x
    return filtered


@njit(cache=True, nogil=True, error_model="numpy")
def decimated(taps: Floats, known: Floats, first: int, factor: int, count: int) -> Floats:
    """Return ``count`` sums of ``taps`` times samples, the first at sample ``first``, the others ``factor`` apart, shape (count, 2).

    Each sum adds its products in the order of time; four sums are computed at once to use the pipelines of the processor.
    """
    sums = np.empty((count, 2))
    whole = count - count % 4
    for k in range(0, whole, 4):
        a = first + k * factor
        b, c, d = a + factor, a + 2 * factor, a + 3 * factor
        ax = ay = bx = by = cx = cy = dx = dy = 0.0
        for tap, weight in enumerate(taps):
            ax += known[a + tap, 0] * weight
            ay += known[a + tap, 1] * weight
            bx += known[b + tap, 0] * weight
            by += known[b + tap, 1] * weight
            cx += known[c + tap, 0] * weight
            cy += known[c + tap, 1] * weight
            dx += known[d + tap, 0] * weight
            dy += known[d + tap, 1] * weight
        sums[k, 0], sums[k, 1], sums[k + 1, 0], sums[k + 1, 1] = ax, ay, bx, by
        sums[k + 2, 0], sums[k + 2, 1], sums[k + 3, 0], sums[k + 3, 1] = cx, cy, dx, dy
    for k in range(whole, count):
        x = y = 0.0
        for tap, weight in enumerate(taps):
            x += known[first + k * factor + tap, 0] * weight
            y += known[first + k * factor + tap, 1] * weight
        sums[k, 0], sums[k, 1] = x, y
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def interpolated(known: Floats, at: Integers, position: Floats, weights: Floats, out: Floats) -> None:
    """Interpolate the first two columns of ``known``, shape (samples, columns), at ``place`` (0 to 1) after the samples ``at``.

    ``weights``, shape (phases + 1, taps), belong to the samples on both sides; they are interpolated linearly between two phases.
    The result goes to ``out``, shape (len(at), 2).
    """
    phases, taps = weights.shape[0] - 1, weights.shape[1]
    for i in range(len(at)):
        row = min(int(position[i] * phases), phases - 1)
        share = position[i] * phases - row
        first = at[i] + 1 - taps // 2
        x = y = 0.0
        for tap in range(taps):
            weight = weights[row, tap] + share * (weights[row + 1, tap] - weights[row, tap])
            x += weight * known[first + tap, 0]
            y += weight * known[first + tap, 1]
        out[i, 0], out[i, 1] = x, y

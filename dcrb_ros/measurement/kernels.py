"""The loops over samples that numpy cannot do at once, compiled. They call nothing, and round alike however the samples are cut."""

from __future__ import annotations

from numba import njit

import dcrb_ros.core  # noqa: F401  names the folder of the compiled kernels
from dcrb_ros.measurement.arrays import Floats, Integers


@njit(cache=True, nogil=True, error_model="numpy")
def filtered(sections: Floats, memory: Floats, samples: Floats) -> Floats:
    """Return ``samples``, shape (samples, columns), through second-order sections, shape (sections, 6), in transposed direct form II.

    ``memory``, shape (sections, 2, columns), is what the sections remember, before and after.
    """
    found: Floats = samples.copy()
    for i in range(found.shape[0]):
        for column in range(found.shape[1]):
            x = found[i, column]
            for k in range(sections.shape[0]):
                y = sections[k, 0] * x + memory[k, 0, column]
                memory[k, 0, column] = sections[k, 1] * x - sections[k, 4] * y + memory[k, 1, column]
                memory[k, 1, column] = sections[k, 2] * x - sections[k, 5] * y
                x = y
            found[i, column] = x
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def between(known: Floats, at: Integers, place: Floats, weights: Floats, out: Floats) -> None:
    """Write the values of ``known``, shape (samples, columns), at a ``place`` from 0 to 1 after the samples ``at`` to ``out``.

    ``weights``, shape (phases + 1, taps), are those of the samples around; between two phases they are interpolated.
    """
    phases, taps = weights.shape[0] - 1, weights.shape[1]
    for i in range(len(at)):
        row = min(int(place[i] * phases), phases - 1)
        share = place[i] * phases - row
        first = at[i] + 1 - taps // 2
        for column in range(out.shape[1]):
            out[i, column] = 0.0
        for tap in range(taps):
            weight = weights[row, tap] + share * (weights[row + 1, tap] - weights[row, tap])
            for column in range(out.shape[1]):
                out[i, column] += weight * known[first + tap, column]

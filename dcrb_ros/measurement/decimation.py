"""Anti-alias filters with exact timing: linear phase, their delay taken out, the same bits for any block size."""

from __future__ import annotations

import numpy as np
import scipy  # whose parts are imported when they are first used

from dcrb_ros.measurement.designs import kept
from dcrb_ros.measurement.kernels import decimated
from dcrb_ros.runtime.arrays import Floats

STOP_ATTENUATION = 85.0
"""Attenuation of what would fold into the pass band [dB]."""
PASS_SHARE = 0.8
"""Pass band as a share of the new Nyquist frequency [-]."""

LARGEST_STAGE = 16


@kept
def anti_alias_taps(factor: int, *, between: bool) -> Floats:
    """Return symmetric taps that let pass up to 0.8 of the new Nyquist frequency.

    The stop band begins where the spectrum would fold back into the pass band (1.2 of the new Nyquist frequency). An even
    number of taps, ``between``, moves the samples by half an input, an odd one leaves them where they are.
    """
    width = 2.0 * (1.0 - PASS_SHARE) / factor
    count, beta = scipy.signal.kaiserord(STOP_ATTENUATION, width)
    count += (count % 2 == 1) == between
    taps: Floats = scipy.signal.firwin(count, 1.0 / factor, window=("kaiser", beta))
    return taps


class Decimator:
    """A decimator for samples in two columns that is fed stretch by stretch.

    Output ``k`` stands at the time of input ``k * factor``; with ``between`` the inputs are means over the interval that
    follows their index, so that the output stands at the interval's beginning. It comes out as soon as ``lead`` inputs
    beyond it are in. Before the start the input is taken as zero.
    """

    def __init__(self, factor: int, *, between: bool = False) -> None:
        if factor < 2:
            raise ValueError(f"a decimation factor of {factor} is below 2")
        self.factor = factor
        self._taps = anti_alias_taps(factor, between=between)
        self.lead = (len(self._taps) - 1) // 2
        """Inputs needed beyond the last output [-]."""
        self._memory = np.zeros((len(self._taps) - 1, 2))
        self._skip = self.lead

    def feed(self, samples: Floats) -> Floats:
        """Filter ``samples`` of shape (inputs, 2); return the outputs that are due, shape (outputs, 2)."""
        known = np.concatenate([self._memory, samples])
        self._memory = known[len(samples) :]
        count = max(0, -(-(len(samples) - self._skip) // self.factor))
        due = decimated(self._taps, known, self._skip, self.factor, count)
        self._skip -= len(samples)
        if self._skip < 0:
            self._skip %= self.factor
        return due


class Cascade:
    """Decimators in a row for large factors; output ``k`` stands at the time of input ``k * factor``."""

    def __init__(self, factor: int) -> None:
        self._stages = [Decimator(stage) for stage in stages(factor)]

    def feed(self, samples: Floats) -> Floats:
        """Filter ``samples`` of shape (inputs, 2); return the outputs that are due, shape (outputs, 2)."""
        for stage in self._stages:
            samples = stage.feed(samples)
        return samples


def stages(factor: int) -> list[int]:
    """Split a decimation factor into stages of at most 16 where it has such divisors."""
    found = []
    while factor > 1:
        divisors = [d for d in range(2, LARGEST_STAGE + 1) if factor % d == 0]
        found.append(divisors[-1] if divisors else factor)
        factor //= found[-1]
    return found

"""Anti-alias filters: linear phase, delay compensated, the same bits for any block size."""

from __future__ import annotations

import functools

import numpy as np
import scipy  # its subpackages are imported on first use

from dcrb_ros.measurement.filter_cache import cached_on_disk
from dcrb_ros.schema.arrays import Floats

STOP_ATTENUATION = 85.0
"""Attenuation of frequencies that alias into the pass band [dB]."""
PASS_SHARE = 0.8
"""Pass band as a share of the new Nyquist frequency [-]."""
LARGEST_STAGE = 16
"""Largest factor of a single stage [-]."""


@functools.cache
@cached_on_disk
def anti_alias_taps(factor: int, *, between: bool) -> Floats:
    """Return the symmetric taps of a low-pass that passes up to 0.8 of the new Nyquist frequency.

    The stop band starts at 1.2 of the new Nyquist frequency, where aliases reach the pass band. With ``between`` the number of taps is
    even, and an output lies half an input interval off its input; otherwise it is odd.
    """
    width = 2.0 * (1.0 - PASS_SHARE) / factor
    count, beta = scipy.signal.kaiserord(STOP_ATTENUATION, width)
    count += (count % 2 == 1) == between
    taps: Floats = scipy.signal.firwin(count, 1.0 / factor, window=("kaiser", beta))
    return taps


class Decimator:
    """A decimator for samples in two columns, processed block by block.

    Output ``k`` belongs to the time of input ``k * factor``. With ``between`` the inputs are means over the interval that follows their
    index, and an output belongs to the start of the interval. An output is returned once ``lead`` inputs after it are known. The input
    before the start is zero.
    """

    def __init__(self, factor: int, *, between: bool = False) -> None:
        if factor < 2:
            raise ValueError(f"a decimation factor of {factor} is below 2")
        self.factor = factor
        self._taps = anti_alias_taps(factor, between=between)
        self.lead = (len(self._taps) - 1) // 2
        """Inputs needed after the last output [-]."""
        self._memory = np.zeros((len(self._taps) - 1, 2))
        self._skip = self.lead

    def process(self, samples: Floats) -> Floats:
        """Filter ``samples``, shape (inputs, 2), and return the outputs that are complete, shape (outputs, 2)."""
        from dcrb_ros.measurement.kernels import decimated  # importing numba takes long

        known = np.concatenate([self._memory, samples])
        self._memory = known[len(samples) :]
        count = max(0, -(-(len(samples) - self._skip) // self.factor))
        due = decimated(self._taps, known, self._skip, self.factor, count)
        self._skip -= len(samples)
        if self._skip < 0:
            self._skip %= self.factor
        return due


class Cascade:
    """Decimators in series for large factors; output ``k`` belongs to the time of input ``k * factor``."""

    def __init__(self, factor: int) -> None:
        self._stages = [Decimator(stage) for stage in stages(factor)]

    def process(self, samples: Floats) -> Floats:
        """Filter ``samples``, shape (inputs, 2), and return the outputs that are complete, shape (outputs, 2)."""
        for stage in self._stages:
            samples = stage.process(samples)
        return samples


def stages(factor: int) -> list[int]:
    """Split a decimation factor into factors of at most 16 where it has such divisors."""
    factors = []
    while factor > 1:
        divisors = [d for d in range(2, LARGEST_STAGE + 1) if factor % d == 0]
        factors.append(divisors[-1] if divisors else factor)
        factor //= factors[-1]
    return factors

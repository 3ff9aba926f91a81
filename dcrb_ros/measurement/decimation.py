"""Anti-alias filters with exact timing: linear phase, their delay taken out, the same bits for any block size."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import signal

STOP_ATTENUATION = 85.0
"""Attenuation of what would fold into the pass band [dB]."""
PASS_SHARE = 0.8
"""Pass band as a share of the new Nyquist frequency [-]."""

LARGEST_STAGE = 16


def anti_alias_taps(factor: int, *, between: bool) -> npt.NDArray[np.float64]:
    """Return symmetric taps that let pass up to 0.8 of the new Nyquist frequency.

    The stop band begins where the spectrum would fold back into the pass band (1.2 of the new Nyquist frequency). An even
    number of taps, ``between``, moves the samples by half an input, an odd one leaves them where they are.
    """
    width = 2.0 * (1.0 - PASS_SHARE) / factor
    count, beta = signal.kaiserord(STOP_ATTENUATION, width)
    count += (count % 2 == 1) == between
    taps: npt.NDArray[np.float64] = signal.firwin(count, 1.0 / factor, window=("kaiser", beta))
    return taps


class Decimator:
    """A decimator for columns of samples that is fed stretch by stretch.

    Output ``k`` stands at the time of input ``k * factor``; with ``between`` the inputs are means over the interval that
    follows their index, so that the output stands at the interval's beginning. It comes out as soon as ``lead`` inputs
    beyond it are in. Before the start the input is taken as zero.
    """

    def __init__(self, factor: int, *, between: bool = False, columns: int = 2) -> None:
        if factor < 2:
            raise ValueError(f"a decimation factor of {factor} is below 2")
        self.factor = factor
        self._taps = anti_alias_taps(factor, between=between)
        self.lead = (len(self._taps) - 1) // 2
        """Inputs needed beyond the last output [-]."""
        # Zeros at the end that change nothing but let the outputs that are due fall on those that upfirdn computes.
        self._padded = np.append(self._taps, np.zeros(-(len(self._taps) - 1) % factor))
        self._memory = np.zeros((len(self._padded) - 1, columns))
        self._skip = self.lead

    def feed(self, samples: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Filter ``samples`` of shape (inputs, columns); return the outputs that are due, shape (outputs, columns)."""
        known, past = np.concatenate([self._memory, samples]), len(self._memory)
        self._memory = known[len(samples) :]
        count = max(0, -(-(len(samples) - self._skip) // self.factor))
        first = past // self.factor
        # Every output sums the same products in the same order, however the inputs are cut.
        filtered = signal.upfirdn(self._padded, known[self._skip :], down=self.factor, axis=0) if count else samples[:0]
        due: npt.NDArray[np.float64] = filtered[first : first + count] if count else filtered
        self._skip -= len(samples)
        if self._skip < 0:
            self._skip %= self.factor
        return due


class Cascade:
    """Decimators in a row for large factors; output ``k`` stands at the time of input ``k * factor``."""

    def __init__(self, factor: int, *, columns: int = 2) -> None:
        self._stages = [Decimator(stage, columns=columns) for stage in stages(factor)]

    def feed(self, samples: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Filter ``samples`` of shape (inputs, columns); return the outputs that are due, shape (outputs, columns)."""
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

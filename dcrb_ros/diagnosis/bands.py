"""A bank of bands and the squared envelope in each: the tree of the fast kurtogram.

Antoni 2007, "Fast computation of the kurtogram for the detection of transient faults": halve the band, halve the halves, and look
where the envelope is most impulsive. Here every band of the tree comes from one transform of a stretch of samples.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft
from scipy.signal.windows import tukey

Floats = npt.NDArray[np.float64]

TAPER = 0.2
"""Share of a band's width that its two edges take together [-]: steep enough for the tree, soft enough not to ring."""
OVERSAMPLING = 2
"""Samples of an envelope per width of its band: its square is twice as wide as the band."""


class Band(NamedTuple):
    """A band of frequencies."""

    low: float
    """Lower edge [Hz]."""
    high: float
    """Upper edge [Hz]."""

    def __str__(self) -> str:
        return f"{self.low / 1e3:.3g} to {self.high / 1e3:.3g} kHz"


def band_tree(low: float, high: float, levels: int) -> tuple[Band, ...]:
    """Return the band from ``low`` to ``high`` [Hz], its halves, their halves and so on, ``levels`` times halved.

    Halves are equally wide on a logarithmic scale: a shock is broad where it is high.
    """
    tree = []
    for count in (2**level for level in range(levels + 1)):
        edges = np.geomspace(low, high, count + 1)
        tree += [Band(float(edges[k]), float(edges[k + 1])) for k in range(count)]
    return tuple(tree)


class BandBank:
    """Squared envelopes of stretches of equal length in several bands."""

    def __init__(self, bands: tuple[Band, ...], rate: int, samples: int) -> None:
        """Take stretches of ``samples`` at ``rate`` [Hz]."""
        self.bands, self.samples = bands, samples
        self._length = fft.next_fast_len(samples, real=True)
        self._bins = [range(round(band.low * self._length / rate), round(band.high * self._length / rate)) for band in bands]
        self._gains = [2.0 * tukey(len(bins), TAPER) for bins in self._bins]

    def squared_envelopes(self, stretch: npt.NDArray[Any]) -> list[tuple[Floats, Floats]]:
        """Return for each band the places [samples] and the squared envelope there, summed over the columns [unit^2].

        ``stretch`` has shape (samples, columns). The mean of an envelope is twice the power in its band.
        """
        spectrum = fft.rfft(np.ascontiguousarray(stretch.T, np.float64), self._length)
        return [self._envelope(spectrum[:, bins.start : bins.stop] * gain) for bins, gain in zip(self._bins, self._gains, strict=True)]

    def _envelope(self, part: npt.NDArray[np.complex128]) -> tuple[Floats, Floats]:
        count = fft.next_fast_len(OVERSAMPLING * part.shape[1])
        analytic = fft.ifft(part, count) * (count / self._length)
        places = np.arange(count, dtype=np.float64) * (self._length / count)
        return np.asarray(places, np.float64), np.asarray((analytic.real**2 + analytic.imag**2).sum(axis=0), np.float64)


def kurtosis(squared: npt.NDArray[Any]) -> Floats:
    """Return the spectral kurtosis of each row of squared envelopes: 0 for noise, large for impacts [-]."""
    mean = squared.mean(axis=1, dtype=np.float64)
    fourth = (squared.astype(np.float64) ** 2).mean(axis=1)
    return np.asarray(np.divide(fourth, mean**2, out=np.full(len(mean), 2.0), where=mean > 0.0) - 2.0, np.float64)

"""Amplitude demodulation: the squared envelope in each of several bands, and the spectral kurtosis by which a band is selected.

The bands form the 1/3-binary tree of the fast kurtogram (Antoni 2007, "Fast computation of the kurtogram for the detection of transient
faults"): the band is divided into halves, thirds and quarters. All bands are computed from one Fourier transform of a segment.

The spectrum may be whitened before, as Borghesani, Pennacchi, Randall, Sawalhi and Ricci 2013, "Application of cepstrum pre-whitening for
the diagnosis of bearing faults under variable speed conditions", Mech. Syst. Signal Process. 36, propose: then no mode of the structure
makes a band narrower than it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

PARTS = (1, 2, 3, 4)
"""Numbers of parts into which a band is divided: the first levels of the 1/3-binary tree."""
TAPER = 0.2
"""Share of a band's width taken by its two edges [-]: steep enough to separate the bands, smooth enough not to ring."""
OVERSAMPLING = 2
"""Samples of an envelope per width of its band: the squared envelope is twice as wide as the band."""
LARGEST_LIFT = 30.0
"""Level below the loudest part of the bands from which on whitening lifts a part of the spectrum less [dB].

A slow bearing has such parts above the frequencies of its waves. Nothing is left there but the faint strikes of healthy rollers at the edge
of the load zone, which must not count as much as the loud parts."""

TONE = 0.5
"""Share of the power within `TONE_WIDTH` from which three neighbouring values are a tone [-].

Impacts at intervals make lines at all multiples of their frequency. Two of them share the power if it is below half of that width."""
TONE_WIDTH = 500.0
"""Width over which the power of a tone is compared [Hz]: impacts up to 250 Hz have two lines in it."""
LEAKAGE = 4
"""Values on either side of a tone that are removed with it [-]: the rest of a segment without a window is 13 dB below."""

QUARTERS = 4
"""Parts of the detector's band in which levels are compared."""
NYQUIST_SHARE = 0.45
"""Highest usable frequency relative to the sampling rate [-]: anti-alias filters act above it."""


class Band(NamedTuple):
    """A band of frequencies."""

    low: float
    """Lower edge [Hz]."""
    high: float
    """Upper edge [Hz]."""

    def __str__(self) -> str:
        return f"{self.low / 1e3:.3g} to {self.high / 1e3:.3g} kHz"


def band_tree(low: float, high: float, parts: Sequence[int] = PARTS) -> tuple[Band, ...]:
    """Return the band from ``low`` to ``high`` [Hz] divided into each number of ``parts``, from the widest to the narrowest.

    The parts have equal widths on a logarithmic scale, since the bandwidth of a resonance grows with its frequency.
    """
    tree = []
    for count in parts:
        edges = np.geomspace(low, high, count + 1)
        tree += [Band(float(edges[k]), float(edges[k + 1])) for k in range(count)]
    return tuple(tree)


def detector_bands(rate: int, low: float, high: float, *, divided: bool) -> tuple[Band, Band, tuple[Band, ...]]:
    """Return the band of a detector from ``low`` to ``high`` [Hz], its upper quarter, and all bands in which it demodulates.

    These are the whole band, its halves, thirds and quarters if it is ``divided``, and the octave below it. The whole band ends where a
    sampling ``rate`` [Hz] ends it.

    Raises:
        Refusal: the sampling rate leaves no band.
    """
    usable = min(high, NYQUIST_SHARE * rate)
    if usable < 1.25 * low:
        raise Refusal(
            f"band_low = {low:g} Hz leaves no band below {usable:g} Hz, the smaller of band_high and {NYQUIST_SHARE:g} of the "
            f"sampling rate of {rate} Hz: it must be at most {usable / 1.25:g} Hz; lower it or sample faster"
        )
    parts = band_tree(low, usable)[1:] if divided else ()
    return Band(low, usable), band_tree(low, high, (QUARTERS,))[-1], (Band(low, usable), *parts, Band(0.5 * low, low))


def tukey(length: int, taper: float) -> Floats:
    """Return a Tukey window, whose edges fall as half a cosine over the share ``taper`` of its length, shape (length,) [-].

    Harris 1978, "On the use of windows for harmonic analysis with the discrete Fourier transform", eq. 38. `scipy.signal.windows.tukey` is
    the same function, but takes a second to import.
    """
    if length < 2:
        return np.ones(length)
    last = length - 1
    edge = np.arange(math.floor(0.5 * taper * last) + 1)
    rise = 0.5 * (1.0 + np.cos(math.pi * (-1.0 + 2.0 * edge / taper / last)))
    fall = 0.5 * (1.0 + np.cos(math.pi * (-2.0 / taper + 1.0 + 2.0 * (last - edge[::-1]) / taper / last)))
    return np.concatenate([rise, np.ones(length - 2 * len(edge)), fall])


class Demodulator:
    """Computes the squared envelopes of segments of equal length in several bands."""

    def __init__(self, bands: tuple[Band, ...], rate: int, samples: int, whitening: float = 0.0, *, tones: bool = True) -> None:
        """Prepare for segments of ``samples`` at ``rate`` [Hz], whitened over a width of ``whitening`` [Hz], 0 for not at all.

        Without ``tones``, those that whitening leaves are removed.
        """
        self.bands, self.samples, self._tones = bands, samples, tones
        self._length = fft.next_fast_len(samples, real=True)
        self._bins = [range(round(band.low * self._length / rate), round(band.high * self._length / rate)) for band in bands]
        counts = [fft.next_fast_len(OVERSAMPLING * len(bins)) for bins in self._bins]
        gains = [2.0 * count / self._length * tukey(len(bins), TAPER) for bins, count in zip(self._bins, counts, strict=True)]
        self._gains = [gain.astype(np.float32) for gain in gains]
        self._range = slice(min(bins.start for bins in self._bins), max(bins.stop for bins in self._bins))
        self._positions = [np.arange(count, dtype=np.float64) * (self._length / count) for count in counts]
        self._width = max(3, round(whitening * self._length / rate)) if whitening > 0.0 else 0
        self._tone_width = max(3, round(TONE_WIDTH * self._length / rate))

    def squared_envelopes(self, segment: npt.NDArray[Any]) -> list[tuple[Floats, Floats]]:
        """Return for each band equally spaced positions [samples] and the squared envelope there, summed over the columns [unit^2].

        ``segment`` has shape (samples, columns). The mean squared envelope is twice the power in the band, whether the spectrum is
        whitened or not. Single precision leaves 140 dB between the loudest and the faintest band.
        """
        largest = float(max(segment.max(initial=0.0), -segment.min(initial=0.0))) or 1.0
        padded = np.zeros((segment.shape[1], self._length), np.float32)
        np.multiply(segment.T, 1.0 / largest, out=padded[:, : len(segment)], casting="same_kind")
        spectrum = fft.rfft(padded)
        power = _summed_squares(spectrum) if self._width else None
        if power is not None and not self._tones:
            removed = self._tonal(power)
            spectrum[:, removed], power[removed] = 0.0, 0.0
        white = self._whitening_gain(power) if power is not None else None
        envelopes = []
        for bins, gain, positions in zip(self._bins, self._gains, self._positions, strict=True):
            part, scale = spectrum[:, bins.start : bins.stop], largest**2
            if white is not None and power is not None:
                weight, before = white[bins.start : bins.stop], power[bins.start : bins.stop]
                passed = np.square(gain)
                # Not by the linear algebra library, whose sums have other bits on other processors.
                passed *= before
                after = float((passed * np.square(weight)).sum(dtype=np.float64))
                scale *= float(passed.sum(dtype=np.float64)) / after if after > 0.0 else 1.0
                gain = gain * weight
            envelopes.append((positions, self._envelope(part, gain, len(positions)) * scale))
        return envelopes

    def _whitening_gain(self, power: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return the gain that makes the local mean of a power spectrum equal wherever it is not quiet, shape (frequencies,).

        With the local mean P and the level Q that is `LARGEST_LIFT` below its largest, it is 1 / sqrt(P) / (1 + Q / P), as of a Wiener
        filter that takes Q for noise.
        """
        local = uniform_filter1d(power.astype(np.float64), self._width, mode="nearest")
        quiet = max(10.0 ** (-LARGEST_LIFT / 10.0) * float(local[self._range].max()), float(np.finfo(np.float32).tiny))
        return np.asarray(np.sqrt(np.maximum(local, 0.0)) / (local + quiet), np.float32)

    def _tonal(self, power: npt.NDArray[np.float32]) -> npt.NDArray[np.bool_]:
        """Return which values of a power spectrum belong to tones, shape (frequencies,)."""
        values = power.astype(np.float64)
        around = self._tone_width * uniform_filter1d(values, self._tone_width, mode="nearest")
        tones = 3.0 * uniform_filter1d(values, 3, mode="nearest") > TONE * around
        return np.asarray(maximum_filter1d(tones, 2 * LEAKAGE + 1), np.bool_)

    def _envelope(self, part: npt.NDArray[Any], gain: npt.NDArray[np.float32], count: int) -> Floats:
        """Return the squared magnitude of the analytic signals with that spectrum at ``count`` samples, summed over the columns."""
        analytic = np.zeros((len(part), count), np.complex64)
        np.multiply(part, gain, out=analytic[:, : len(gain)])
        analytic = fft.ifft(analytic, overwrite_x=True)
        squared = np.square(analytic.real)
        squared += np.square(analytic.imag)
        return np.asarray(squared.sum(axis=0, dtype=np.float64), np.float64)


def _summed_squares(spectrum: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Return the squared magnitudes summed over the rows of a spectrum, shape (frequencies,)."""
    power = np.square(spectrum.real)
    power += np.square(spectrum.imag)
    return np.asarray(power.sum(axis=0), np.float32)


def kurtosis(squared: npt.NDArray[Any]) -> Floats:
    """Return the spectral kurtosis of each row of squared envelopes, shape (bands, bins): 0 for noise, large for impacts [-]."""
    mean = squared.mean(axis=1, dtype=np.float64)
    relative = squared * np.divide(1.0, mean, out=np.zeros(len(mean)), where=mean > 0.0)[:, None].astype(squared.dtype)
    fourth = np.einsum("ij,ij->i", relative, relative) / max(1, squared.shape[1])
    return np.asarray(np.where(mean > 0.0, fourth, 2.0) - 2.0, np.float64)

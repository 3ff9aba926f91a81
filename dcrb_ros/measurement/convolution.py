"""Convolution with a long impulse response without delay, the same bits for any block size."""

from __future__ import annotations

import numpy as np

from dcrb_ros.schema.arrays import Floats

FRAME = 256
"""Steps of a frame: later taps act on whole frames."""


class Convolution:
    """A causal filter with finite impulse responses for two columns; the input before the start is zero.

    Frames of 256 steps are tied to the first sample. The first 256 taps are sums of products of fixed length and order. All later taps act
    on completed frames by overlap-save, one partition of the response for each frame (Gardner 1995, J. Audio Eng. Soc. 43(3), 127-136).
    Both parts depend on the number of a sample alone, not on how the samples are split into blocks.
    """

    def __init__(self, response: Floats) -> None:
        """Prepare for impulse responses, shape (2, taps)."""
        partitions = max(2, -(-response.shape[1] // FRAME) - 1)
        partitions += partitions % 2
        padded = np.zeros((2, (partitions + 1) * FRAME))
        padded[:, : response.shape[1]] = response
        self._near = padded[:, :FRAME].copy()
        later = np.fft.rfft(padded[:, FRAME:].reshape(2, partitions, FRAME), 2 * FRAME).swapaxes(0, 1)
        self._later = np.ascontiguousarray(np.stack([later.real, later.imag], axis=2))
        """Spectra of the later taps, real and imaginary parts, shape (partitions, 2, 2, bins)."""
        self._spectra = np.zeros_like(self._later)
        self._newest = 0
        """Position of the newest frame in the ring of spectra."""
        self._known = np.zeros((2, 2 * FRAME - 1))
        """Input before the next sample."""
        self._filled = 0
        """Samples of the present frame."""
        self._tail = np.zeros((2, FRAME))
        """What complete frames add to the present one."""

    def process(self, samples: Floats) -> Floats:
        """Return ``samples``, shape (samples, 2), after the filter."""
        from dcrb_ros.measurement.kernels import near_sums  # importing numba takes long

        known, filled, before = np.concatenate([self._known, samples.T], axis=1), self._filled, self._known.shape[1]
        filtered = near_sums(self._near, known, before)
        tails = np.concatenate([self._tail, self._tails(known[:, before - FRAME - filled :])], axis=1)
        filtered += tails[:, filled : filled + len(samples)]
        self._filled = (filled + len(samples)) % FRAME
        self._known, self._tail = known[:, len(samples) :].copy(), tails[:, -FRAME:].copy()
        return np.ascontiguousarray(filtered.T)

    def _tails(self, known: Floats) -> Floats:
        """Return what the frames that ``known`` completes add to the next ones, shape (2, samples); it begins with the one before."""
        from dcrb_ros.measurement.kernels import later_spectra

        frames = known[:, : known.shape[1] // FRAME * FRAME].reshape(2, -1, FRAME)
        if frames.shape[1] < 2:
            return np.zeros((2, 0))
        spectra = np.fft.rfft(np.concatenate([frames[:, :-1], frames[:, 1:]], axis=2))
        sums = later_spectra(self._later, self._spectra, self._newest, spectra)
        self._newest = (self._newest + sums.shape[1]) % len(self._spectra)
        return np.fft.irfft(sums, 2 * FRAME)[:, :, FRAME:].reshape(2, -1)

"""Convolution with a long impulse response without delay, the same bits for any block size."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

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
        later = np.zeros((partitions, 2, 2 * FRAME))
        later[:, :, :FRAME] = padded[:, FRAME:].reshape(2, partitions, FRAME).swapaxes(0, 1)
        self._later = _parts(np.fft.rfft(later))
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
        filtered = near_sums(self._near, np.ascontiguousarray(known[:, before - (FRAME - 1) :]))
        tails = np.concatenate([self._tail, *self._tails(known[:, before - FRAME - filled :])], axis=1)
        filtered += tails[:, filled : filled + len(samples)]
        self._filled = (filled + len(samples)) % FRAME
        self._known, self._tail = known[:, len(samples) :].copy(), tails[:, -FRAME:].copy()
        return np.ascontiguousarray(filtered.T)

    def _tails(self, known: Floats) -> Floats:
        """Return what the frames that ``known`` completes add to the next ones, shape (frames, 2, FRAME); it begins with the one before."""
        from dcrb_ros.measurement.kernels import product_sums

        pairs = [known[:, first : first + 2 * FRAME] for first in range(0, known.shape[1] - 2 * FRAME + 1, FRAME)]
        if not pairs:
            return np.zeros((0, 2, FRAME))
        sums = np.empty((len(pairs), *self._later.shape[1:]))
        for total, spectrum in zip(sums, _parts(np.fft.rfft(np.stack(pairs))), strict=True):
            self._newest = (self._newest + 1) % len(self._spectra)
            self._spectra[self._newest] = spectrum
            total[:] = product_sums(self._later, self._spectra, self._newest)
        return np.fft.irfft(sums[:, :, 0] + 1j * sums[:, :, 1], 2 * FRAME)[:, :, FRAME:]


def _parts(spectrum: npt.NDArray[np.complex128]) -> Floats:
    """Return real and imaginary parts, shape (..., 2, bins)."""
    return np.stack([spectrum.real, spectrum.imag], axis=-2)

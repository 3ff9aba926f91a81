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
        self._memory = np.zeros((2, FRAME - 1))
        """Input before the next sample."""
        self._frames = np.zeros((2, 2 * FRAME))
        """The last complete frame and the present one."""
        self._filled = 0
        """Samples of the present frame."""
        self._tail = np.zeros((2, FRAME))
        """What complete frames add to the present one."""

    def process(self, samples: Floats) -> Floats:
        """Return ``samples``, shape (samples, 2), after the filter."""
        from dcrb_ros.measurement.kernels import near_sums  # importing numba takes long

        known = np.concatenate([self._memory, samples.T], axis=1)
        self._memory = known[:, len(samples) :].copy()
        filtered = near_sums(self._near, known)
        done = 0
        while done < len(samples):
            part = min(FRAME - self._filled, len(samples) - done)
            end = self._filled + part
            filtered[:, done : done + part] += self._tail[:, self._filled : end]
            self._frames[:, FRAME + self._filled : FRAME + end] = samples[done : done + part].T
            done, self._filled = done + part, end
            if end == FRAME:
                self._complete()
        return np.ascontiguousarray(filtered.T)

    def _complete(self) -> None:
        """Add the complete frame to the spectra and begin the next one."""
        from dcrb_ros.measurement.kernels import product_sums

        self._newest = (self._newest + 1) % len(self._spectra)
        self._spectra[self._newest] = _parts(np.fft.rfft(self._frames))
        sums = product_sums(self._later, self._spectra, self._newest)
        self._tail = np.fft.irfft(sums[:, 0] + 1j * sums[:, 1], 2 * FRAME)[:, FRAME:]
        self._frames[:, :FRAME] = self._frames[:, FRAME:]
        self._filled = 0


def _parts(spectrum: npt.NDArray[np.complex128]) -> Floats:
    """Return real and imaginary parts, shape (..., 2, bins)."""
    return np.stack([spectrum.real, spectrum.imag], axis=-2)

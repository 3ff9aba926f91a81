"""Noise with the spectrum that a signal has had so far."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.schema.arrays import Floats

HALF_FRAME = 0.02
"""Least time between two frames [s]; a frame has twice this length."""


class FollowingNoise:
    """Gaussian noise with the slow mean of the power spectrum of a signal of two columns.

    Frames of 2N steps start every N steps, counted from the first one. Each takes the mean spectrum of the frames before it, and its noise
    rises and falls as half a sine, so that the power is constant. The result depends on the number of a step alone, not on how the
    signal is split into blocks. There is no noise before the first two half frames have passed.
    """

    def __init__(self, random: np.random.Generator, rate: float, smoothing: float) -> None:
        """Prepare for a rate of steps [Hz] and a time constant of the mean [s]."""
        self._half = 2 ** math.ceil(math.log2(HALF_FRAME * rate))
        self._random = random
        self._least_share = -math.expm1(-self._half / (smoothing * rate))
        steps = (np.arange(2 * self._half) + 0.5) / (2 * self._half)
        self._rise = np.sin(np.pi * steps)[:, None]
        """Weight of a frame; those of two frames have squares with the sum 1."""
        # A window of Hann, whose side lobes stay below the power that falls towards high frequencies.
        self._analysis = self._rise**2 / np.sqrt(np.sum(self._rise**4))
        self._power = np.zeros((self._half + 1, 2))
        """Mean power spectrum, 1 for white noise of the mean square 1."""
        self._frames = 0
        """Half frames that have passed."""
        self._known = np.zeros((0, 2))
        """Signal since the start of the half frame before the present one."""
        self._noise = np.zeros((2 * self._half, 2))
        """Noise of the present half frame and what it leaves to the next one."""

    def process(self, signal: Floats) -> Floats:
        """Return noise beside a ``signal``, shape (steps, 2)."""
        noise, done = np.empty_like(signal), 0
        while done < len(signal):
            filled = len(self._known) - min(self._frames, 1) * self._half
            steps = min(self._half - filled, len(signal) - done)
            noise[done : done + steps] = self._noise[filled : filled + steps]
            self._known = np.concatenate([self._known, signal[done : done + steps]])
            done += steps
            if filled + steps == self._half:
                self._next_frame()
        return noise

    def _next_frame(self) -> None:
        self._frames += 1
        self._noise = np.concatenate([self._noise[self._half :], np.zeros((self._half, 2))])
        if self._frames < 2:
            return
        spectrum = np.abs(np.fft.rfft(self._known * self._analysis, axis=0)) ** 2
        self._power += max(self._least_share, 1.0 / (self._frames - 1)) * (spectrum - self._power)
        white = np.fft.rfft(self._random.standard_normal((2 * self._half, 2)), axis=0)
        self._noise += self._rise * np.fft.irfft(white * np.sqrt(self._power), axis=0)
        self._known = self._known[self._half :]

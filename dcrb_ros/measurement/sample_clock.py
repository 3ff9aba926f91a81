"""The sample clock of the ADC: samples are taken off the nominal times that their stamps state."""

from __future__ import annotations

import math

import numpy as np
import scipy  # its subpackages are imported on first use

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Setup
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

HALF_WIDTH = 14
"""Samples on either side from which a value between two samples is interpolated."""
BETA = 8.3
"""Shape of the Kaiser window [-]: 85 dB, like the anti-alias filter."""
PHASES = 1024
"""Places between two samples with tabulated weights; linear interpolation of the weights has an error below 2e-6."""
MOST_JITTER = 6.0
"""Largest error of a sample's time in multiples of its rms [-]."""


class ClockParameters(Group):
    """Offset and jitter of the sample clock."""

    clock_offset_ppm: float = quantity(
        0.0, "ppm", "Offset of the sample clock: positive if samples are taken later than their stamps state", -1000.0, 1000.0
    )
    clock_jitter: float = quantity(
        0.0, "s", "Jitter of the sample clock: rms error of the sampling times", 0.0, 1e-5, remedy="give seconds, 1 ns is 1e-9"
    )


def interpolation_weights() -> Floats:
    """Return the weights of a Kaiser-windowed sinc for the places from one sample to the next, shape (PHASES + 1, 2 HALF_WIDTH)."""
    phase = np.arange(PHASES + 1) / PHASES
    distance = phase[:, None] - np.arange(1 - HALF_WIDTH, HALF_WIDTH + 1)[None, :]
    inside = np.clip(1.0 - (distance / HALF_WIDTH) ** 2, 0.0, None)
    weights: Floats = np.sinc(distance) * scipy.special.i0(BETA * np.sqrt(inside)) / scipy.special.i0(BETA)
    return weights


class SampleClock:
    """Takes sample ``k`` at the time (k (1 + offset) + jitter) / rate, from samples at whole ticks of an exact clock."""

    def __init__(self, setup: Setup) -> None:
        clock = setup.parameters[ClockParameters]
        self._offset = clock.clock_offset_ppm * 1e-6
        self._jitter = clock.clock_jitter * setup.sampling_rate
        self._ahead = math.ceil(MOST_JITTER * self._jitter) + HALF_WIDTH
        """Samples on either side that a sample may depend on."""
        self._random = random_stream(setup.seed, "clock_jitter")
        self._weights = interpolation_weights()
        self._begin = -self._ahead - 1
        """Tick of the first sample in memory; samples before the start are zero."""
        self._known = np.zeros((self._ahead + 1, 3))
        self._taken = 0

    def sample_at(self, tick: int) -> int:
        """Return the first sample that is taken at or after a tick of the exact clock, apart from jitter."""
        return math.ceil(tick / (1.0 + self._offset))

    def needed(self, count: int) -> int:
        """Return the ticks needed to take ``count`` samples."""
        return count + math.floor((count - 1) * self._offset) + self._ahead + 1

    def process(self, samples: Floats, angle: Floats) -> tuple[Floats, Floats]:
        """Return acceleration, shape (samples, 2) [m/s^2], and shaft angle, shape (samples,) [rad], at the times of this clock."""
        from dcrb_ros.measurement.kernels import interpolated  # importing numba takes long

        self._known = np.concatenate([self._known, np.column_stack([samples, angle])])
        if self._begin + len(self._known) > 0 and self._taken == 0:
            # Before the start the shaft is at its first angle, not at zero.
            self._known[: -self._begin, 2] = self._known[-self._begin, 2]
        count = self._due()
        index = np.arange(self._taken, self._taken + count)
        late = index * self._offset
        if self._jitter > 0.0:
            late = late + self._jitter * np.clip(self._random.standard_normal(count), -MOST_JITTER, MOST_JITTER)
        whole = np.floor(late)
        at, share = index + whole.astype(np.int64) - self._begin, late - whole
        taken = np.empty((count, 2))
        interpolated(self._known, at, share, self._weights, taken)
        turned = self._known[at, 2] + share * (self._known[at + 1, 2] - self._known[at, 2])
        self._taken += count
        self._forget()
        return taken, turned

    def _due(self) -> int:
        """Return how many samples can be taken from the samples in memory."""
        reached = self._begin + len(self._known)
        count = max(0, math.floor((reached - self._ahead) / (1.0 + self._offset)) - self._taken + 2)
        while count > 0 and self.needed(self._taken + count) > reached:
            count -= 1
        return count

    def _forget(self) -> None:
        """Drop the samples that no later one depends on."""
        oldest = self._taken + math.floor(self._taken * self._offset) - self._ahead - 1
        gone = max(0, oldest - self._begin)
        self._known, self._begin = self._known[gone:], self._begin + gone

"""The converter's own clock: samples taken off their nominal times, which their stamps still say."""

from __future__ import annotations

import math

import numpy as np
from scipy import special

from dcrb_ros.measurement.kernels import between
from dcrb_ros.measurement.streams import stream
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

HALF_WIDTH = 14
"""Samples on either side from which a value between two is made."""
BETA = 8.3
"""Shape of the Kaiser window: 85 dB, as the anti-alias filter's [-]."""
PHASES = 1024
"""Places between two samples for which the weights are kept; between them they are interpolated, which errs by less than 2e-6."""
MOST_JITTER = 6.0
"""Largest error of a sample's time in multiples of its rms [-]."""


def interpolation_weights() -> Floats:
    """Return the weights of a windowed sinc for every place from one sample to the next, shape (PHASES + 1, 2 HALF_WIDTH)."""
    place = np.arange(PHASES + 1) / PHASES
    distance = place[:, None] - np.arange(1 - HALF_WIDTH, HALF_WIDTH + 1)[None, :]
    inside = np.clip(1.0 - (distance / HALF_WIDTH) ** 2, 0.0, None)
    weights: Floats = np.sinc(distance) * special.i0(BETA * np.sqrt(inside)) / special.i0(BETA)
    return weights


class Clock:
    """Takes sample ``k`` at (k (1 + offset) + jitter) over the rate, from samples at whole ticks of a true clock."""

    def __init__(self, configuration: Configuration) -> None:
        sensor = configuration.sensor
        self._offset = sensor.clock_offset_ppm * 1e-6
        self._jitter = sensor.clock_jitter * sensor.sampling_rate
        self._ahead = math.ceil(MOST_JITTER * self._jitter) + HALF_WIDTH
        """Samples on either side that one sample may need."""
        self._random = stream(configuration.simulation.seed, "clock_jitter")
        self._weights = interpolation_weights()
        self._begin = -self._ahead - 1
        """Tick of the first sample kept; before the start they are zero."""
        self._known = np.zeros((self._ahead + 1, 3))
        self._taken = 0

    def sample_at(self, tick: int) -> int:
        """Return the first sample that is taken at or after a tick of the true clock, but for jitter."""
        return math.ceil(tick / (1.0 + self._offset))

    def needed(self, count: int) -> int:
        """Return the ticks needed until ``count`` samples are taken."""
        return count + math.floor((count - 1) * self._offset) + self._ahead + 1

    def feed(self, samples: Floats, angle: Floats) -> tuple[Floats, Floats]:
        """Return acceleration, shape (samples, 2) [m/s^2], and shaft angle [rad] at the times of this clock that are due."""
        self._known = np.concatenate([self._known, np.column_stack([samples, angle])])
        if self._begin + len(self._known) > 0 and self._taken == 0:
            # The shaft stood where it was before the start: nothing turns backwards out of zero.
            self._known[: -self._begin, 2] = self._known[-self._begin, 2]
        count = self._due()
        index = np.arange(self._taken, self._taken + count)
        late = index * self._offset
        if self._jitter > 0.0:
            late = late + self._jitter * np.clip(self._random.standard_normal(count), -MOST_JITTER, MOST_JITTER)
        whole = np.floor(late)
        at, place = index + whole.astype(np.int64) - self._begin, late - whole
        taken = np.empty((count, 2))
        between(self._known, at, place, self._weights, taken)
        turned = self._known[at, 2] + place * (self._known[at + 1, 2] - self._known[at, 2])
        self._taken += count
        self._forget()
        return taken, turned

    def _due(self) -> int:
        """Return how many samples can be taken from what is known."""
        reached = self._begin + len(self._known)
        count = max(0, math.floor((reached - self._ahead) / (1.0 + self._offset)) - self._taken + 2)
        while count > 0 and self.needed(self._taken + count) > reached:
            count -= 1
        return count

    def _forget(self) -> None:
        """Let go of what no later sample needs."""
        oldest = self._taken + math.floor(self._taken * self._offset) - self._ahead - 1
        gone = max(0, oldest - self._begin)
        self._known, self._begin = self._known[gone:], self._begin + gone

"""The prescribed speed of the shaft: its ramp towards the commanded speed, and its random fluctuation."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.settings.configuration import Configuration

KNOT = 0.002
"""Time between two values of the fluctuating speed [s], which changes linearly between them: 25 per turn at 1200 rpm."""
FADE = 0.1
"""Time in which the fluctuation begins [s]: a run starts from a steady state."""
LOWEST, HIGHEST, TONES = 0.1, 5.0, 16
"""Frequencies of the slow fluctuation [Hz] and how many there are: with one per equal part of a decade their power falls as 1/f."""
RIPPLE = np.array([1.0, 2.0])
"""Orders of the ripple; its amplitudes fall as one over the order."""
ROUNDING = 1e-9
"""Excess of a ramp over the way to its end [-], so that rounding does not keep the speed short of it."""


class ShaftSpeed:
    """Prescribes the speed at the ends of equal intervals of time steps, as a target and the ramp that reaches it.

    With the commanded speed Omega after its ramp, the shaft's angle theta and the time t,

        omega = Omega (1 + sum_k a_k cos(2 pi f_k t + phi_k) + sum_n b_n cos(n theta + psi_n))

    The random frequencies and phases follow from ``simulation.seed``; the fluctuation is bounded by the sum of all amplitudes, 5.7 times
    ``speed_fluctuation`` and 1.9 times ``speed_ripple``. It depends on time step and shaft angle alone, not on blocks.
    """

    def __init__(self, configuration: Configuration) -> None:
        operating, random = configuration.operating, random_stream(configuration.simulation.seed, "fluctuation of the speed")
        self.fluctuates = operating.speed_fluctuation > 0.0 or operating.speed_ripple > 0.0
        """Whether the speed is anything but its ramp."""
        self.interval = max(1, round(KNOT * configuration.step_rate))
        """Time steps between two values."""
        self._step = 1.0 / configuration.step_rate
        self.commanded = operating.speed
        """The speed that the ramp approaches [rad/s]."""
        self._base = operating.speed
        edges = np.geomspace(LOWEST, HIGHEST, TONES + 1)
        self._frequencies = edges[:-1] * (edges[1:] / edges[:-1]) ** random.random(TONES)
        self._phases = 2.0 * math.pi * random.random(TONES)
        self._slow = operating.speed_fluctuation * math.sqrt(2.0 / TONES)
        self._ripple_phases = 2.0 * math.pi * random.random(len(RIPPLE))
        self._ripple = operating.speed_ripple * math.sqrt(2.0) / RIPPLE / math.sqrt(float((RIPPLE**-2.0).sum()))

    def relative(self, time: float, angle: float) -> float:
        """Return the fluctuation [-] at a time [s] and an angle of the shaft [rad]."""
        slow = self._slow * np.cos(2.0 * math.pi * self._frequencies * time + self._phases).sum()
        ripple = (self._ripple * np.cos(RIPPLE * angle + self._ripple_phases)).sum()
        return min(1.0, time / FADE) * float(slow + ripple)

    def next(self, steps: int, angle: float, speed: float, ramp: float) -> tuple[float, float]:
        """Return the speed [rad/s] after the interval that begins at step ``steps``, and the ramp that reaches it from ``speed`` [rad/s^2].

        ``ramp`` is the rate at which the shaft approaches the commanded speed.
        """
        duration = self.interval * self._step
        self._base += min(max(self.commanded - self._base, -ramp * duration), ramp * duration)
        target = self._base * (1.0 + self.relative((steps + self.interval) * self._step, angle + self._base * duration))
        return target, (1.0 + ROUNDING) * abs(target - speed) / duration

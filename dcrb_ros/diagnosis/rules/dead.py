"""A dead sensor: only noise is left."""

from __future__ import annotations

import itertools
import math
from collections import deque

import numpy as np
from scipy import fft

from dcrb_ros.diagnosis.evidence import SAME_SPEED, SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

LOWEST = 200.0
"""Lowest frequency that counts [Hz]: below it the noise of amplifiers is pink, and the mains hum."""
HIGHEST_SHARE = 0.4
"""Highest frequency that counts, as a share of the sampling rate [-]: anti-alias filters act above it."""
BLOCKS = 16
"""Blocks of equal width in which the power density is compared."""
REMEMBERED = 120
"""Hops from whose powers the usual one is taken: a minute."""
FASTEST = 1000.0
"""Highest frequency at which a machine is expected to modulate its noise [Hz]: rollers pass less often."""
CHANCE = 1e-4
"""Probability with which the power of stationary noise is taken to vary [-]."""
FEWEST_LINES = 64
"""Lines of the spectrum in a block: the level of noise then scatters by half a decibel."""


class DeadParameters(Group):
    """Thresholds for noise."""

    dead_level: float = quantity(
        9.0,
        "dB",
        "Largest difference between the power densities of 16 parts of the spectrum up to which it is noise, which has 2",
        0.0,
        60.0,
    )
    dead_white: float = quantity(
        2.0,
        "dB",
        "The same difference up to which it is noise whatever the level was before: nothing of the machine is left",
        0.0,
        60.0,
    )
    dead_fall: float = quantity(
        10.0,
        "dB",
        "Decrease of the power from its median so far that a sensor shows which dies; one that has always been noisy is alive",
        0.0,
        120.0,
    )
    dead_kurtosis: float = quantity(4.0, "-", "Kurtosis below which a flat spectrum is noise, which has 3; impacts have 6", 3.0, 100.0)


class Dead(SampleRule[DeadParameters]):
    """A white spectrum without impacts: no structure transmits vibration equally at all frequencies.

    A working sensor may be so noisy that a quiet bearing hardly shows. Its spectrum is whiter than that of any structure, but less white
    than noise alone, and its power has not fallen at the same speed. A sensor whose spectrum is as white as noise alone still works if its
    power follows the machine: the noise of an amplifier is stationary, the vibration of a machine is cyclostationary.
    """

    parameters = DeadParameters
    fault = "dead sensor that leaves noise"

    def __init__(self, parameters: DeadParameters) -> None:
        super().__init__(parameters)
        self._powers: dict[str, deque[tuple[float, float]]] = {}
        """Shaft frequency [Hz] and power [(m/s^2)^2] of the latest hops in which an axis was alive."""

    def shortest_hop(self, rate: int) -> float:
        """Return the length of a hop with `FEWEST_LINES` in every block of the spectrum [s]."""
        return BLOCKS * FEWEST_LINES / max(HIGHEST_SHARE * rate - LOWEST, 1.0)

    def restart(self) -> None:
        """Discard earlier hops."""
        self._powers.clear()

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            spread, power = self._spread_of_noise(column, evidence.rate), float(np.var(column))
            before = self._powers.setdefault(axis, deque(maxlen=REMEMBERED))
            # A bearing falls silent with the shaft: powers are compared at the same speed only.
            usual = [power for speed, power in before if abs(speed - evidence.frequency) <= SAME_SPEED * speed]
            fallen = evidence.frequency > 0.0 and bool(usual) and power < float(np.median(usual)) * 10.0 ** (-self.p.dead_fall / 10.0)
            noise = spread is not None and spread < (self.p.dead_level if fallen else self.p.dead_white)
            if noise and (fallen or not power_varies(column, evidence.rate)):
                return f"the acceleration in {axis} is white noise, whose power density varies by {spread:.1f} dB only: the sensor is dead"
            before.append((evidence.frequency, power))
        return ""

    def _spread_of_noise(self, column: Floats, rate: int) -> float | None:
        """Return the range of the power density over frequency [dB], or none if the samples have impacts or are too few."""
        centred = column - column.mean()
        squared = np.square(centred)
        mean = float(np.mean(squared))
        if float(np.mean(np.square(squared))) / mean**2 >= self.p.dead_kurtosis:
            return None
        edges = np.linspace(LOWEST, HIGHEST_SHARE * rate, BLOCKS + 1) * len(column) / rate
        if edges[1] - edges[0] < FEWEST_LINES:
            return None
        # Single precision has 140 dB, of which a tenth matters.
        spectrum = fft.rfft((centred * (1.0 / math.sqrt(mean))).astype(np.float32))
        power = np.square(spectrum.real) + np.square(spectrum.imag)
        levels = [float(power[round(low) : round(high)].mean()) for low, high in itertools.pairwise(edges)]
        return 10.0 * math.log10(max(*levels, 1e-30) / max(min(levels), 1e-30))


def power_varies(column: Floats, rate: int) -> bool:
    """Return whether the power of noise varies periodically, as that of a machine does.

    In stationary noise, the squared amplitudes of the spectrum of x(t)^2 are exponentially distributed, so that the largest of n exceeds
    their mean t times with a probability of n exp(-t).
    """
    spectrum = fft.rfft(column - column.mean())
    inside = slice(round(LOWEST * len(column) / rate), round(HIGHEST_SHARE * rate * len(column) / rate))
    kept = np.zeros_like(spectrum)
    kept[inside] = spectrum[inside]
    squared = np.square(fft.irfft(kept, len(column)))
    lines = np.square(np.abs(fft.rfft(squared - squared.mean())[1 : max(3, round(FASTEST * len(column) / rate))]))
    mean = float(np.median(lines)) / math.log(2.0)
    return float(lines.max()) > mean * math.log(len(lines) / CHANCE)

"""The sensor's health by its samples, before anything is said of the bearing: dead, stuck, saturated, spikes, senseless numbers."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy import fft

from dcrb_ros.diagnosis.envelope import median
from dcrb_ros.diagnosis.parameters import DetectorParameters

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

AXES = "XY"
FEWEST_SAMPLES = 64
"""Samples below which a hop says nothing."""
FEWEST_VALUES = 16
"""Different values that a signal must take for its flat ends to be a limit and no coarse converter."""
LOW = (200.0, 2000.0)
"""Where a turning bearing is always louder than a sensor's noise: rollers pass the load line [Hz]."""
HIGH_SHARES = (0.2, 0.45)
"""Band that this is compared with, over the sampling rate [-]."""


class SampleHealth:
    """Looks at the samples of every hop."""

    def __init__(self, parameters: DetectorParameters, rate: int, sensor_range: float) -> None:
        """Know the sampling rate [Hz] and the sensor's range [m/s^2], 0 where it is not told."""
        self._parameters, self._rate, self.range = parameters, rate, sensor_range
        self.clipped = 0
        """Samples at the ends of the range so far."""
        self._spikes: list[int] = []

    def flaw(self, acceleration: Floats, missing: Flags, senseless: int, *, turning: bool = True) -> str:
        """Return what is wrong with a hop of samples, shape (samples, 2) [m/s^2], or nothing; ``senseless`` of them are no numbers.

        Silence is a flaw where the bearing is ``turning``; one that stands has nothing to say.
        """
        p, count = self._parameters, len(missing)
        if senseless > p.most_senseless * count:
            return f"{senseless} of {count} samples are no finite numbers"
        known = acceleration[~missing] if missing.any() else acceleration
        if len(known) < FEWEST_SAMPLES:
            return ""
        columns = np.ascontiguousarray(known.T)
        looks = (self._still, self._stuck, self._saturated, self._dead) if turning else (self._saturated,)
        flaws = (look(name, column) for look in looks for name, column in zip(AXES, columns, strict=True))
        return next((flaw for flaw in flaws if flaw), "") or self._spiking(columns)

    def _still(self, axis: str, column: Floats) -> str:
        return f"the acceleration in {axis} does not change: the sensor is dead" if float(np.ptp(column)) == 0.0 else ""

    def _stuck(self, axis: str, column: Floats) -> str:
        """Look for runs of one and the same value that last."""
        least = max(2, round(self._parameters.stuck_time * self._rate))
        ends, runs = runs_of_one_value(column)
        long = (runs >= least) & (np.abs(column[ends]) < max(float(column.max()), -float(column.min())))
        share = float(runs[long].sum()) / len(column)
        if share <= self._parameters.stuck_share:
            return ""
        return f"the acceleration in {axis} repeats itself for {share:.0%} of the time: the sensor sticks"

    def _saturated(self, axis: str, column: Floats) -> str:
        """Look for flat ends: count them at the range, and call them a fault below it or where they are many."""
        p, ends = self._parameters, (float(column.max()), float(column.min()))
        flat = [column == end for end in ends]
        clipped = sum(int(np.count_nonzero(at)) for at in flat if np.any(at[1:] & at[:-1]))
        if not clipped or len(np.unique(column[: 16 * FEWEST_VALUES])) < FEWEST_VALUES:
            return ""
        self.clipped += clipped
        limit, share = max(abs(end) for end in ends), clipped / len(column)
        if share > p.most_clipped or (share > p.least_clipped and limit < p.range_share * self.range):
            told = f" where its range is {self.range:g}" if self.range else ""
            return f"the acceleration in {axis} stands at {limit:.3g} m/s^2{told} for {share:.1%} of the time: the sensor saturates"
        return ""

    def _dead(self, axis: str, column: Floats) -> str:
        """Look for noise only: as loud where a turning bearing is silent as where it is not, and without its impacts."""
        p = self._parameters
        centred = column - column.mean()
        squared = np.square(centred)
        if float(np.mean(np.square(squared))) / float(np.mean(squared)) ** 2 >= p.dead_kurtosis:
            return ""
        power = np.abs(fft.rfft(centred)) ** 2
        low, high = (power[slice(*(round(edge * len(column) / self._rate) for edge in band))] for band in (LOW, self._high))
        level = 10.0 * math.log10(max(float(low.mean()), 1e-30) / max(float(high.mean()), 1e-30))
        if level >= p.dead_level:
            return ""
        return f"the acceleration in {axis} is noise, only {level:.1f} dB louder where a bearing is heard: the sensor is dead"

    @property
    def _high(self) -> tuple[float, float]:
        return HIGH_SHARES[0] * self._rate, HIGH_SHARES[1] * self._rate

    def _spiking(self, columns: Floats) -> str:
        """Look for jumps out of the quiet within one sample that do not ring: a blow on the bearing swings to the other side."""
        p = self._parameters
        found = sum(spikes(column, max(4, round(p.spike_time * self._rate)), p) for column in columns)
        self._spikes = [*self._spikes, found][-max(1, round(p.window / p.hop)) :]
        if sum(self._spikes) < p.most_spikes or not found:
            return ""
        return f"{sum(self._spikes)} spikes that no body could follow are in the window: a cable or its plug is loose"


def runs_of_one_value(column: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return where runs of two and more equal samples end, and how long they are."""
    equal = np.flatnonzero(column[1:] == column[:-1])
    if not len(equal):
        return equal, equal
    border = np.diff(equal) != 1
    first, last = equal[np.concatenate([[True], border])], equal[np.concatenate([border, [True]])]
    return last + 1, last - first + 2


BEFORE = 4
"""Samples before a spike that must be quiet."""


def spikes(column: Floats, after: int, p: DetectorParameters) -> int:
    """Return how many samples jump out of the quiet to their height at once, and do not swing back within ``after`` samples."""
    centred = column - median(column)
    size, steps = np.abs(centred), np.abs(np.diff(centred))
    # Where most samples are larger than that, so is their median: no step is high enough, and it need not be worked out.
    if 2 * np.count_nonzero(size > 1.001 * float(steps.max()) / p.spike_height) > len(column) + 1:
        return 0
    least = p.spike_height * float(median(size))
    jumps = np.flatnonzero(steps > least) + 1
    jumps = jumps[(jumps >= BEFORE) & (jumps < len(column) - after)]
    if not len(jumps) or least == 0.0:
        return 0
    top = centred[jumps]
    before = np.abs(centred[jumps[:, None] - np.arange(1, BEFORE + 1)]).max(axis=1)
    course = np.sign(top)[:, None] * centred[jumps[:, None] + np.arange(after)]
    height, highest, swing = np.abs(top), course.max(axis=1), -course.min(axis=1)
    sharp = (before < p.spike_quiet * height) & (height > p.spike_front * highest) & (swing < p.spike_swing * height)
    return int(np.count_nonzero(sharp & (height > least)))

"""The pulses of a tacho, and what follows from them: turns and speed of the shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arguments import numbers
from dcrb_ros.schema.arrays import Floats, Integers

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class TachoPulses:
    """The rising edges of a tacho on the shaft. The direction of rotation is unknown."""

    time: Floats
    """Time of each pulse, shape (pulses,) [s]."""
    number: Integers
    """Number of each pulse since the start, shape (pulses,); it jumps where pulses were lost."""
    pulses_per_turn: int
    """Pulses per turn of the shaft; 0 without a tacho, or if unknown."""

    def __call__(self) -> TachoPulses:
        """Return itself: ``tacho`` of a run or a recording is read with or without parentheses."""
        return self

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        span = f", {self.time[0]:.4g} to {self.time[-1]:.4g} s" if len(self) else ""
        return f"<TachoPulses: {len(self)} pulses{span}, {self.pulses_per_turn} per turn>"

    def turns(self, time: npt.ArrayLike) -> Floats:
        """Return the turns of the shaft since the first pulse at some times [s], same shape [-]; NaN before the first and after the last.

        The turns are interpolated linearly between pulses. A fluctuation faster than the pulses is therefore lost.

        Raises
        ------
        Refusal
            The times are no numbers.
        """
        numbers("time", time)
        at = np.asarray(time, np.float64)
        if len(self) < 2 or not self.pulses_per_turn:
            return np.full(at.shape, math.nan)
        turned = (self.number - self.number[0]) / float(self.pulses_per_turn)
        return np.asarray(np.interp(at, self.time, turned, left=math.nan, right=math.nan), np.float64)

    @property
    def speed(self) -> Floats:
        """Mean speed of the shaft from each pulse to the next, shape (pulses - 1,) [rad/s]; NaN if the pulses per turn are unknown."""
        turned = np.diff(self.number) / self.pulses_per_turn if self.pulses_per_turn else np.full(max(0, len(self) - 1), math.nan)
        return np.asarray(2.0 * math.pi * turned / np.diff(self.time), np.float64)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s] with the columns pulse and speed, the mean since the pulse before [rad/s].

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        speed = np.concatenate([np.full(min(1, len(self)), math.nan), self.speed])
        return pandas().DataFrame({"pulse": self.number, "speed": speed}, index=pandas().Index(self.time, name="time"))

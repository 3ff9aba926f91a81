"""An estimated parameter with its interval."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

LEVEL = 0.9
"""Probability with which an interval is meant to contain the value [-]."""
QUANTILE = 1.6448536269514722
"""Standard deviations on either side of the estimate that a normal variable keeps within with that probability [-]."""


@dataclass(frozen=True)
class EstimatedParameter:
    """A parameter of the bench as a recording shows it."""

    key: str
    """Key of the configuration."""
    value: float
    low: float
    """Lower end of the interval."""
    high: float
    """Upper end of the interval."""
    unit: str
    log: bool = False
    """Whether the interval is one of the logarithm, so that a sweep draws evenly there."""

    def __post_init__(self) -> None:
        if not self.low <= self.value <= self.high:
            raise ValueError(f"{self.key} = {self.value:g} is outside its interval {self.low:g} .. {self.high:g}")

    def divided(self, factor: float) -> EstimatedParameter:
        """Return the estimate of the value over a factor [-]."""
        return replace(self, value=self.value / factor, low=self.low / factor, high=self.high / factor)

    def __str__(self) -> str:
        return f"{self.key} = {self.value:.4g} ({self.low:.4g} to {self.high:.4g}) {self.unit}".removesuffix(" -")


def by_factor(key: str, value: float, deviation: float, unit: str) -> EstimatedParameter:
    """Return the estimate of a positive value from the standard deviation of its logarithm."""
    factor = math.exp(QUANTILE * min(deviation, 5.0))
    return EstimatedParameter(key, value, value / factor, value * factor, unit, log=True)


def by_difference(key: str, value: float, deviation: float, unit: str) -> EstimatedParameter:
    """Return the estimate of a value that is not negative from its standard deviation."""
    return EstimatedParameter(key, value, max(0.0, value - QUANTILE * deviation), value + QUANTILE * deviation, unit)


@dataclass(frozen=True)
class PathLevel:
    """Gain of the path in a third octave, with the gain of the recording."""

    axis: str
    frequency: float
    """Middle of the band [Hz]."""
    level: float
    """10 lg of the power gain, weighted by the spectrum of the source [dB]."""
    low: float
    """Lower end of the interval [dB]."""
    high: float
    """Upper end of the interval [dB]."""
    share: float
    """Share of the bearing in the measured power [-]; below a half the noise covers it, and the level is an extrapolation."""
    chance: float = 0.0
    """Standard deviation of the level for the individual of the bench's bearing [dB]; the interval contains other individuals, too."""

    @property
    def identified(self) -> bool:
        """Whether the bearing rises above the noise in the band."""
        return self.share >= 0.5

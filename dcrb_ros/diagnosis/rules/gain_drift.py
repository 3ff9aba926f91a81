"""A gain that drifts: all bands have fallen together at the same speed."""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.evidence import LevelEvidence
from dcrb_ros.diagnosis.rule import LevelRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

FEWEST_BANDS = 2
"""Bands with more signal than noise that show a common fall."""


class GainDriftParameters(Group):
    """Thresholds for a common fall of all bands."""

    gain_drop: float = quantity(3.0, "dB", "Decrease of all bands at the same speed that indicates a falling gain of the sensor", 0.5, 60.0)
    gain_spread: float = quantity(
        0.25,
        "-",
        "Largest difference between the decreases of the bands relative to their mean; a gain causes 0.2, a change of load 0.3",
        0.01,
        10.0,
    )


class GainDrift(LevelRule[GainDriftParameters]):
    """A fall of the mean level with little difference between the bands, from the first hops at a speed to the latest.

    A gain g lowers the signal S_k of each band, but not the noise N_k of the sensor, so that its power becomes g^2 S_k + N_k. The fall must
    be common to the powers of all bands, as without noise, or to S_k in the bands that had more signal than noise at first. Random impacts
    vary from one hop to the next. The mean of the latest powers, and each of the latest S_k, must therefore be lower than each of the first
    ones by the whole drop.
    """

    parameters = GainDriftParameters

    def __init__(self, parameters: GainDriftParameters) -> None:
        super().__init__(parameters)
        self._low = False
        """Whether the levels fell together and have stayed low."""

    def flaw(self, evidence: LevelEvidence) -> str:
        levels = evidence.levels
        heard = levels.signal[np.isfinite(levels.signal)]
        changes = [levels.change, *([heard] if len(heard) >= FEWEST_BANDS else [])]
        together = [self._alike(levels.change, levels.fall), self._alike(heard, levels.signal_fall)]
        # Further down the noise of the sensor dominates in the weaker bands, and they no longer fall together.
        self._low = any(together) or (self._low and any(float(change.max()) <= -self.p.gain_drop for change in changes))
        fall = -float(changes[-1].mean())
        return f"all bands have decreased by {fall:.1f} dB at the same speed: the gain of the sensor drifts" if self._low else ""

    def _alike(self, change: Floats, fall: float) -> bool:
        """Return whether several bands have fallen by enough, and in the mean nearly by the same [dB]."""
        return len(change) >= FEWEST_BANDS and fall >= self.p.gain_drop and float(np.ptp(change)) <= -self.p.gain_spread * change.mean()

"""Loss of lubricant by vibration alone: without films, rolling surfaces are loud at all high frequencies, and no lines appear.

The power of the quarters of the band is compared with what was learned from this bearing at the same speed, so that no level of a machine
matters. The median rise of the quarters counts: a resonance that a defect excites is in one or two of them. Anything else that is loud at
all frequencies rises them, too: another load, a track, a rail joint, a wheel flat. The rule is therefore off unless a threshold is given.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from dcrb_ros.diagnosis.heat_rule import HeatFinding
from dcrb_ros.diagnosis.rule import Rule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

SAME_SPEED = 0.05
"""Relative width of the speeds that are learned together [-]."""
AVERAGED_HOPS = 4
"""Hops over which levels are averaged."""


class StarvedNoiseParameters(Group):
    """Threshold of the rise, and how long the healthy level is learned."""

    starved_noise: float = quantity(
        0.0, "dB", "Rise of the high frequencies at the same speed, without lines, that is a loss of lubricant; 0 to ignore it", 0.0, 60.0
    )
    starved_learn: float = quantity(3.0, "s", "Signal at a speed from which its healthy level is learned", 0.5, 1e5)


class StarvedNoise(Rule[StarvedNoiseParameters]):
    """A rise of the median level of the quarters of the band."""

    parameters = StarvedNoiseParameters

    def __init__(self, parameters: StarvedNoiseParameters) -> None:
        super().__init__(parameters)
        self._sums: dict[int, tuple[int, Floats]] = {}
        """Hops and the sum of their levels [dB] by speed."""
        self._latest: deque[Floats] = deque(maxlen=AVERAGED_HOPS)
        self._place: int | None = None

    def finding(self, powers: Floats, frequency: float, interval: float) -> HeatFinding | None:
        """Take the power of each quarter of the band in a hop [(m/s^2)^2] of an ``interval`` [s]; return the evidence, if any.

        None while the rule is off, as long as too little is known, and at an unknown frequency of the shaft [Hz], given as 0.
        """
        if not self.p.starved_noise or frequency <= 0.0 or not np.all(powers > 0.0):
            return None
        speed = round(math.log(frequency) / SAME_SPEED)
        if speed != self._place:
            self._latest.clear()
            self._place = speed
        levels = 10.0 * np.log10(powers)
        hops, total = self._sums.get(speed, (0, np.zeros(len(powers))))
        if hops * interval < self.p.starved_learn:
            self._sums[speed] = hops + 1, total + levels
            return None
        self._latest.append(levels)
        if len(self._latest) < AVERAGED_HOPS:
            return None
        rise = float(np.median(np.mean(self._latest, axis=0) - total / hops))
        reason = f"the vibration at high frequencies has risen by {rise:.1f} dB at the same speed, without lines: its films are gone"
        return HeatFinding("lubrication", rise - self.p.starved_noise, reason)

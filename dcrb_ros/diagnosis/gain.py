"""The sensor's health by its levels: a gain that falls, and a mounting that is loose."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.parameters import DetectorParameters

Floats = npt.NDArray[np.float64]

SETTLING = 4
"""Hops whose mean is compared: half of them make a level that its scatter does not move by a decibel."""
SAME_SPEED = 0.03
"""Change of the shaft frequency from which levels are not compared any more, relative."""


class LevelHealth:
    """Watches the power in every band, hop by hop."""

    def __init__(self, parameters: DetectorParameters) -> None:
        self._parameters = parameters
        self._latest: deque[Floats] = deque(maxlen=SETTLING)
        self._reference: Floats | None = None
        self._frequency = 0.0
        self._firm = parameters.firm_level
        self._low = False
        """Whether the levels fell together and have stayed down."""

    def forget(self) -> None:
        """Begin anew."""
        self._latest.clear()
        self._reference = None
        self._low = False

    def flaw(self, powers: npt.NDArray[np.floating], frequency: float, *, high: int | None, below: int) -> str:
        """Return what is wrong with the ``powers`` of bands beside each other, or nothing.

        ``high`` is the place of the band from which a mounting is judged, if the sampling rate lets it be seen, ``below`` that of
        the lowest.
        """
        silence = 2.0 * self._parameters.silence**2
        if 0.0 < float(powers.max()) < silence:
            return f"no band holds more than {self._parameters.silence:g} m/s^2: the sensor is dead, or the signal below its resolution"
        if not np.all(powers > 0.0) or frequency <= 0.0:
            return ""
        if abs(frequency - self._frequency) > SAME_SPEED * self._frequency:
            self.forget()
            self._frequency = frequency
        self._latest.append(10.0 * np.log10(np.asarray(powers, np.float64)))
        if len(self._latest) < SETTLING:
            return ""
        levels = np.mean(self._latest, axis=0)
        if self._reference is None:
            self._reference = levels
        return self._fallen(levels - self._reference) or (self._loose(float(levels[high] - levels[below])) if high is not None else "")

    def _fallen(self, change: Floats) -> str:
        p = self._parameters
        fall = -float(change.mean())
        together = len(change) > 1 and fall >= p.gain_drop and float(np.ptp(change)) <= p.gain_spread * fall
        # Further down the sensor's noise holds up the weaker bands, and they no longer fall together.
        self._low = together or (self._low and float(change.max()) <= -p.gain_drop)
        if not self._low:
            return ""
        return f"all bands have fallen by {fall:.1f} dB at the same speed: the sensor's gain drifts"

    def _loose(self, level: float) -> str:
        p = self._parameters
        self._firm = max(self._firm, level)
        if level > p.loose_level or level > self._firm - p.loose_drop:
            return ""
        return f"the high band has fallen to {-level:.1f} dB below the low one, from {-self._firm:.1f} dB: the sensor's mounting is loose"

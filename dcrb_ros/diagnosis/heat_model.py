"""The rise of a healthy bearing's temperature above ambient: a model with two parameters, learned while the bearing is healthy.

    rise(t) = a + b u(t),        u = 0.3 z + 0.7 x
    dz/dt = (h - z) / 180 s,     dx/dt = (h - x) r(f),     h = (f / 15 Hz)^0.7 (P / 100 kN)^0.25

``f`` is the frequency of the shaft and ``P`` the load. ``b`` is the rise at 15 Hz (156 km/h on wheels of 0.92 m), ``a`` an offset of the
sensors and of the sun. The ring leads the box (``z``), whose own temperature follows at the rate ``r`` (``x``): after 22 minutes at 15 Hz,
after 78 minutes at rest. Exponents, shares and rates are those of the thermal network (`dcrb_ros.bearing.quasi_steady`) with the grease of
the bench `healthy`: the steady rise of its outer ring has exponents of 0.70 to 0.74 over 5 to 20 Hz and of 0.22 to 0.30 over 60 to 140 kN.

``a`` and ``b`` have a normal prior and follow by Bayesian linear regression (Bishop, Pattern Recognition and Machine Learning, 2006,
eq. 3.50, 3.51 and 3.58 for the deviation of a prediction). Errors of the model last: readings within half an hour count as one.
Heat from outside, such as the sun's, makes an error that is larger the less air cools the box: 3.6 times as large at rest as at 15 Hz.
"""

from __future__ import annotations

import math

REFERENCE_FREQUENCY, REFERENCE_LOAD = 15.0, 100e3
"""Shaft frequency [Hz] and load [N] at which a bearing rises by ``b``."""
LEAST_LOAD = 160.0
"""Load below which the rise no longer falls [N]: seals, cage and grease heat an unloaded bearing by a fifth of ``b``."""
SPEED_EXPONENT, LOAD_EXPONENT = 0.7, 0.25
"""Of the steady rise above ambient [-]."""
RING_SHARE, RING_LAG = 0.3, 180.0
"""Share of the rise by which the ring is hotter than the box [-], and how soon [s]."""
LAG, LAG_AT_REST, AIR_EXPONENT = 1300.0, 4700.0, 0.8
"""Time constant of the box at the reference frequency and at rest [s], and exponent of the cooling by the air (Hilpert 1933) [-]."""
ONE_OBSERVATION = 1800.0
"""Time within which the errors of the model are one and the same [s]."""
OFFSET_DEVIATION = 2.0
"""Standard deviation of the offset before anything is learned [K]."""
WARMEST_START = 1.25
"""Largest ``x`` with which a bearing is taken to begin [-]: a bearing that begins hot is no healthy one."""
START_DEVIATION = 0.2
"""Standard deviation of the ``x`` with which it begins [-]."""


class HeatModel:
    """Follows the operation of one bearing; predicts its rise above ambient, and learns from readings."""

    def __init__(self, rise: float, rise_deviation: float, error: float, error_share: float) -> None:
        """Begin with a prior.

        ``rise`` and ``rise_deviation`` are mean and standard deviation of ``b``, ``error`` and ``error_share`` those of the model's error:
        a constant part [K] and one relative to the rise [-].
        """
        self._error, self._share = error, error_share
        self.offset, self.rise = 0.0, rise
        """Present means of ``a`` and ``b`` [K]."""
        self._aa, self._ab, self._bb = OFFSET_DEVIATION**2, 0.0, rise_deviation**2
        self._ring = self._box = 0.0
        self._stray = 1.0
        """Rise of the box by heat from outside, such as the sun, over that at the reference frequency [-]."""
        self._doubt = START_DEVIATION
        self._begun = False

    def follow(self, frequency: float, load: float, duration: float, rise: float) -> None:
        """Follow a shaft frequency [Hz] and load [N] (NaN where it is unknown) that lasted for a duration [s]; ``rise`` [K] begins it."""
        wanted = (abs(frequency) / REFERENCE_FREQUENCY) ** SPEED_EXPONENT
        if not math.isnan(load):
            wanted *= (max(abs(load), LEAST_LOAD) / REFERENCE_LOAD) ** LOAD_EXPONENT
        air = (abs(frequency) / REFERENCE_FREQUENCY) ** AIR_EXPONENT
        rate = 1.0 / LAG_AT_REST + (1.0 / LAG - 1.0 / LAG_AT_REST) * air
        if not self._begun:
            self._stray = 1.0 / (LAG * rate)
            self._begun, self._ring = True, wanted
            self._box = min(max((rise / self.rise - RING_SHARE * wanted) / (1.0 - RING_SHARE), 0.0), WARMEST_START)
            return
        kept = math.exp(-rate * duration)
        self._ring = wanted + (self._ring - wanted) * math.exp(-duration / RING_LAG)
        self._box = wanted + (self._box - wanted) * kept
        self._doubt *= kept
        self._stray = 1.0 / (LAG * rate) + (self._stray - 1.0 / (LAG * rate)) * kept

    def restart(self) -> None:
        """Discard how warm the bearing is, not what has been learned."""
        self._begun, self._doubt = False, START_DEVIATION

    @property
    def known(self) -> bool:
        """Whether the temperature with which the bearing began has died away."""
        return self._begun and self._doubt < 0.2 * START_DEVIATION

    @property
    def expected(self) -> float:
        """Expected rise above ambient [K]."""
        return self.offset + self.rise * self._heat

    @property
    def deviation(self) -> float:
        """Standard deviation of a reading from it [K]: error of the model, of its parameters, and of the beginning."""
        heat, begin = self._heat, (1.0 - RING_SHARE) * self.rise * self._doubt
        parameters = self._aa + 2.0 * heat * self._ab + heat**2 * self._bb
        return math.sqrt(self._variance + max(parameters, 0.0) + begin**2)

    @property
    def least_rise(self) -> float:
        """Rise at the reference frequency that the bearing has at least, two standard deviations below the mean [K]."""
        return self.rise - 2.0 * math.sqrt(max(self._bb, 0.0))

    def learn(self, rise: float, duration: float) -> None:
        """Take a rise [K] that was observed over a duration [s]."""
        heat = self._heat
        along_a, along_b = self._aa + heat * self._ab, self._ab + heat * self._bb
        observed = along_a + heat * along_b + self._variance * max(ONE_OBSERVATION / duration, 1.0)
        miss = rise - self.expected
        self.offset += along_a / observed * miss
        self.rise += along_b / observed * miss
        self._aa -= along_a * along_a / observed
        self._ab -= along_a * along_b / observed
        self._bb -= along_b * along_b / observed

    @property
    def _heat(self) -> float:
        return RING_SHARE * self._ring + (1.0 - RING_SHARE) * self._box

    @property
    def _variance(self) -> float:
        return (self._error * self._stray) ** 2 + (self._share * self.rise * self._heat) ** 2

"""Rattling of a loose mount: it transmits one direction better than the other."""

from __future__ import annotations

import numpy as np

from dcrb_ros.measurement.parameters import Accelerometer
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats

RATTLE = 0.3
"""Half the difference between the gains of the two directions of a fully loose mount [-]: 1.3 and 0.7."""


class Rattle(Stage):
    """a + r |a| with r in proportion to the severity of a loose mount: even harmonics of every tone."""

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._share = 0.0

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._share = RATTLE * parameters[Accelerometer].severity("loose")

    @property
    def active(self) -> bool:
        return self._share > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration + self._share * np.abs(acceleration)

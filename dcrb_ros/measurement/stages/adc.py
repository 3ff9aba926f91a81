"""The analogue-to-digital converter: rounding to its steps."""

from __future__ import annotations

import numpy as np

from dcrb_ros.measurement.parameters import Accelerometer
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class AdcParameters(Group):
    """Resolution of the ADC."""

    adc_bits: int = quantity(24, "bit", "Resolution of the ADC over the range; 0 for no rounding", 0, 32, run_time=True)


class Adc(Stage):
    """Rounds to steps of range / 2^(bits - 1)."""

    parameters = AdcParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._step = 0.0

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        bits = parameters[AdcParameters].adc_bits
        self._step = parameters[Accelerometer].range / 2.0 ** (bits - 1) if bits > 0 else 0.0

    @property
    def active(self) -> bool:
        return self._step > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return np.round(acceleration / self._step) * self._step

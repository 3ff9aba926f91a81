"""Pink noise of the electronics, whose power falls with 1/f."""

from __future__ import annotations

from dcrb_ros.measurement.filters import Filter, pink
from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class PinkNoiseParameters(Group):
    """Density of the 1/f noise."""

    pink_noise_ug: float = quantity(
        0.0,
        "ug/sqrt(Hz)",
        "1/f noise: density at 1 Hz; the density is inversely proportional to the square root of the frequency",
        0.0,
        1e6,
        run_time=True,
    )


class PinkNoise(Stage):
    """Adds white noise through a filter that falls by 10 dB per decade."""

    parameters = PinkNoiseParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._filter, self._random, self._density = Filter(pink(rate)), random_stream(setup.seed, "pink_noise"), 0.0

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._density = parameters[PinkNoiseParameters].pink_noise_ug * MICRO_G

    @property
    def active(self) -> bool:
        return self._density > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration + self._density * self._filter.process(self._random.standard_normal(acceleration.shape))

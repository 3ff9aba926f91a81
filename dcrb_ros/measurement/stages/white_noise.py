"""White noise of sensor and electronics."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class WhiteNoiseParameters(Group):
    """Density of the white noise, in SI units and as data sheets give it."""

    noise_density: float = quantity(
        2e-3,
        "m/s^2/sqrt(Hz)",
        "White noise density; IEPE sensors of 100 mV/g have 1e-5 to 1e-4, that is 1 to 10 ug/sqrt(Hz), MEMS sensors 2.5e-4 to 4e-3",
        0.0,
        10.0,
        remedy="100 ug/sqrt(Hz) is 0.00098 m/s^2/sqrt(Hz)",
        run_time=True,
    )
    white_noise_ug: float = quantity(
        0.0,
        "ug/sqrt(Hz)",
        "White noise density in the unit of data sheets; its power is added to that of noise_density",
        0.0,
        1e6,
        run_time=True,
    )


class WhiteNoise(Stage):
    """Adds Gaussian noise of rms d sqrt(f_s / 2) for a one-sided density d.

    It draws random numbers even at a density of zero, so that a change while the simulation runs does not shift the sequence.
    """

    parameters = WhiteNoiseParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._random, self._rms = np.random.Generator(np.random.Philox(setup.seed)), 0.0

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        noise = parameters[WhiteNoiseParameters]
        density = noise.noise_density
        if noise.white_noise_ug > 0.0:
            density = math.hypot(density, noise.white_noise_ug * MICRO_G)
        self._rms = float(density * np.sqrt(0.5 * self.rate))

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration + self._rms * self._random.standard_normal(acceleration.shape)

"""Noise of the machine beside its bearing: other sources that reach the sensor, and the bearing's share of the power."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.measurement.filters import Filter
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.modulation import ShaftModulation
from dcrb_ros.measurement.stages.path import cascade, pairs, problems_of
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, choice, quantity


class MachineNoiseParameters(Group):
    """Spectrum of the noise, and the share of the bearing."""

    bearing_share: float = quantity(
        1.0,
        "-",
        "Share of the healthy bearing in the power at the sensor; the rest is noise of the machine. 1 for none",
        1e-6,
        1.0,
        remedy="give a share, not per cent",
    )
    noise_x: float = quantity(
        0.0, "m/s^2/sqrt(Hz)", "Density of the noise of the machine in X below its sections, at a share of the bearing of 0", 0.0, 1e6
    )
    noise_y: float = quantity(0.0, "m/s^2/sqrt(Hz)", "The same in Y", 0.0, 1e6)
    noise_path_x: str = choice("", "Spectrum of the noise of the machine in X, as pairs of poles and zeros like those of path_x")
    noise_path_y: str = choice("", "The same in Y")


class MachineNoise(Stage):
    r"""Adds noise of the machine behind the path and scales the bearing to its share.

    With the share s of the bearing, its acceleration a behind the path and Gaussian noise n,

    .. math:: a' = \sqrt{s} \, a + \sqrt{1 - s} \, n, \qquad P_n(f) = d^2 |H_n(f)|^2 ,

    so that the power does not depend on s where n has the spectrum of the healthy a, as in a calibration. A fault changes a alone. Both are
    modulated by the shaft alike.
    """

    group, parameters = "structure", MachineNoiseParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        noise = setup.parameters[MachineNoiseParameters]
        self._share = noise.bearing_share
        self._rms = np.array([noise.noise_x, noise.noise_y]) * math.sqrt(0.5 * rate)
        self._random = random_stream(setup.seed, "machine noise")
        axes = [pairs(text, key) for key, text in _paths(noise).items()]
        self._filters = [Filter(cascade(axis, rate), columns=1) if axis else None for axis in axes]
        self._modulation = ShaftModulation(setup, rate)

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        noise = parameters[MachineNoiseParameters]
        for key, text in _paths(noise).items():
            yield from problems_of(key, text, step_rate)
        if noise.bearing_share < 1.0 and noise.noise_x == noise.noise_y == 0.0:
            yield (
                f"structure.bearing_share = {noise.bearing_share:g} leaves the rest to noise of the machine, which has no level: give "
                "structure.noise_x and noise_y, or a share of 1"
            )

    @property
    def active(self) -> bool:
        return self._share < 1.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        noise = self._rms * self._random.standard_normal(acceleration.shape)
        for axis, bank in enumerate(self._filters):
            if bank is not None:
                noise[:, axis : axis + 1] = bank.process(noise[:, axis : axis + 1])
        if self._modulation.active:
            noise = self._modulation.process(noise, span)
        return math.sqrt(self._share) * acceleration + math.sqrt(1.0 - self._share) * noise


def _paths(noise: MachineNoiseParameters) -> dict[str, str]:
    return {"structure.noise_path_x": noise.noise_path_x, "structure.noise_path_y": noise.noise_path_y}

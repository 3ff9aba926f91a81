"""The bias of the sensor: a constant offset and its random walk."""

from __future__ import annotations

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class BiasParameters(Group):
    """Offset and drift."""

    bias: float = quantity(0.0, "m/s^2", "Constant bias of both axes", -1e4, 1e4)
    bias_drift: float = quantity(0.0, "m/s^2/sqrt(s)", "Random walk of the bias: rms after one second", 0.0, 100.0)


class Bias(Stage):
    """Adds an offset that is constant or walks at random."""

    parameters = BiasParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        bias = setup.parameters[BiasParameters]
        self._offset = np.full(2, bias.bias)
        self._step = bias.bias_drift / np.sqrt(rate)
        self._random = random_stream(setup.seed, "bias_drift")

    @property
    def active(self) -> bool:
        return bool(self._step > 0.0 or self._offset.any())

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration + (self._random_walk(len(acceleration)) if self._step > 0.0 else self._offset)

    def _random_walk(self, count: int) -> Floats:
        """Return the offset of the next samples, shape (samples, 2) [m/s^2]."""
        steps = self._step * self._random.standard_normal((count, 2))
        path: Floats = np.empty((count + 1, 2))
        for axis in (0, 1):
            np.cumsum(np.concatenate([self._offset[axis : axis + 1], steps[:, axis]]), out=path[:, axis])
        self._offset = path[-1]
        return path[1:]

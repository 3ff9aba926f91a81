"""Gravity, which a sensor that measures constant acceleration reads as an acceleration upwards."""

from __future__ import annotations

import numpy as np

from dcrb_ros.measurement.stage import Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class GravityParameters(Group):
    """Gravity as the sensor reads it."""

    static_gravity: float = quantity(
        0.0,
        "m/s^2",
        "What the sensor reads along Y at rest: 9.80665 upright, negative upside down, 0 for a sensor that reads changes only",
        -100.0,
        100.0,
    )


class Gravity(Stage):
    """Adds gravity: an accelerometer measures the force that holds its mass, at rest against the weight."""

    parameters = GravityParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._at_rest = np.array([0.0, setup.parameters[GravityParameters].static_gravity])

    @property
    def active(self) -> bool:
        return bool(self._at_rest[1] != 0.0)

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return np.asarray(acceleration + self._at_rest)

"""Modulation of the bearing's noise by the turning shaft, as by a load that turns with it."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class ModulationParameters(Group):
    """Depth of the modulation."""

    modulation: float = quantity(
        0.0,
        "-",
        "Modulation of the outer ring's acceleration once per revolution, relative amplitude: a load that turns with the shaft causes it",
        0.0,
        1.0,
        remedy="give a share, not per cent",
    )


class ShaftModulation(Stage):
    """Multiplies the acceleration of the ring by 1 + m cos(angle of the shaft + phase); the phase is drawn by the seed.

    The squared envelope then has a line at order 1 of the amplitude 2 m / (1 + m^2/2) over its mean (Randall and Antoni 2011, Mech.
    Syst. Signal Process. 25(2), 485-520, section 3).
    """

    group, parameters = "structure", ModulationParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._depth = setup.parameters[ModulationParameters].modulation
        self._phase = 2.0 * math.pi * float(random_stream(setup.seed, "modulation").random())

    @property
    def active(self) -> bool:
        return self._depth > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        modulated: Floats = acceleration * (1.0 + self._depth * np.cos(span.angle[1:] + self._phase))[:, None]
        return modulated

"""The temperature sensors at outer ring and axle box and in the air: lag, noise and resolution, once per simulated second."""

from __future__ import annotations

import math
from collections.abc import Sequence

from dcrb_ros.bearing.heat_network import HeatNetwork
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.states import TemperatureReading

FROM_RING = 0.6
"""Share of the outer ring's temperature in that of the housing over the load zone [-]; the box has the rest (a choice)."""


class TemperatureSensors:
    """Follows the temperatures of the network, and reads them."""

    def __init__(self, configuration: Configuration, network: HeatNetwork, temperatures: Sequence[float]) -> None:
        self._network = network
        self._random = random_stream(configuration.simulation.seed, "temperature sensors")
        self._ring = temperatures[network.outer(network.rows - 1)]
        self._well = self._place(temperatures)
        self._due = 0

    def _place(self, temperatures: Sequence[float]) -> float:
        """Return the temperature of the housing over the load zone [deg C]."""
        ring, box = temperatures[self._network.outer(self._network.rows - 1)], temperatures[self._network.box]
        return FROM_RING * ring + (1.0 - FROM_RING) * box

    def follow(self, configuration: Configuration, temperatures: Sequence[float], duration: float) -> None:
        """Let the sensors follow temperatures [deg C] that have lasted for a duration of heat [s]."""
        self._ring = temperatures[self._network.outer(self._network.rows - 1)]
        self._well += (self._place(temperatures) - self._well) * -math.expm1(-duration / configuration.thermal.sensor_lag)

    def reading(self, configuration: Configuration, steps: int, time_ns: int) -> TemperatureReading | None:
        """Return what the sensors read at a step; None within a second after the reading before."""
        if steps < self._due:
            return None
        self._due += configuration.step_rate
        thermal = configuration.thermal
        noise = thermal.sensor_noise * self._random.standard_normal(3)
        true = (self._ring, self._well, thermal.ambient)
        values = [value + error for value, error in zip(true, noise.tolist(), strict=True)]
        if thermal.sensor_resolution > 0.0:
            values = [round(value / thermal.sensor_resolution) * thermal.sensor_resolution for value in values]
        return TemperatureReading(time_ns, *values)

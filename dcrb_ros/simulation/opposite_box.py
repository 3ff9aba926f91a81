"""The healthy bearing at the other end of the axle, to which wayside detectors compare a box: its temperatures, without a time loop."""

from __future__ import annotations

from dcrb_ros.bearing.heat_network import Vector
from dcrb_ros.bearing.quasi_steady import QuasiSteady, Running
from dcrb_ros.settings.configuration import Configuration

PERIOD = 1.0
"""Simulated time between two steps [s]."""
SPEED_RESOLUTION = 0.5
"""Step of the speed for which its heat is evaluated [rad/s]."""


class OppositeBox:
    """Runs at the speed of the shaft under the configured load, with the heat of steady running (`dcrb_ros.bearing.quasi_steady`)."""

    def __init__(self, configuration: Configuration) -> None:
        healthy = configuration.model_copy(update={"faults": type(configuration.faults)()})
        self._steady = QuasiSteady(healthy)
        self._running: Running = self._steady.running()
        self._elapsed = 0.0
        nodes = self._steady.network.box + 1
        cold = configuration.thermal.start == "cold"
        self._temperatures: Vector = [configuration.thermal.ambient] * nodes if cold else self._steady.steady(self._running)

    @property
    def box(self) -> float:
        """Temperature of its box [deg C]."""
        return self._temperatures[self._steady.network.box]

    @property
    def outer_ring(self) -> float:
        """Temperature of its outer ring [deg C]."""
        return self._temperatures[self._steady.network.outer(0)]

    def follow(self, configuration: Configuration, speed: float, duration: float) -> None:
        """Follow the shaft's speed [rad/s] over a duration [s] of simulated time."""
        self._elapsed += duration
        if self._elapsed < PERIOD:
            return
        heated, self._elapsed = self._elapsed * configuration.thermal.acceleration, 0.0
        near = round(speed / SPEED_RESOLUTION) * SPEED_RESOLUTION
        if near != self._running.speed:
            self._running = self._steady.running(near)
        # The heat follows the temperature within a minute, however fast the time lapse.
        parts = max(1, round(heated / 60.0))
        for _ in range(min(parts, 20)):
            self._temperatures = self._steady.after(
                self._running, self._temperatures, heated / min(parts, 20), ambient=configuration.thermal.ambient
            )

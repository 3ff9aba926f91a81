"""The healthy bearing at the other end of the axle, to which wayside detectors compare a box: its temperatures, without a time loop."""

from __future__ import annotations

from dcrb_ros.bearing.heat_network import Vector
from dcrb_ros.bearing.quasi_steady import QuasiSteady, Running
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import load_and_weight

PERIOD = 1.0
"""Simulated time between two steps [s]."""
SPEED_RESOLUTION = 0.5
"""Step of the speed for which its heat is evaluated [rad/s]."""


class OppositeBox:
    """Runs at the speed and load of the shaft in the configured air, with the heat of steady running (`dcrb_ros.bearing.quasi_steady`)."""

    def __init__(self, configuration: Configuration) -> None:
        self._run(configuration, configuration.operating.speed, load_and_weight(configuration))
        self._elapsed = 0.0
        nodes = self._steady.network.box + 1
        cold = configuration.thermal.start == "cold"
        self._temperatures: Vector = [configuration.thermal.ambient] * nodes if cold else self._steady.steady(self._running)

    def _run(self, configuration: Configuration, speed: float, load: float) -> None:
        """Run from now on as configured but for the faults, at a speed [rad/s] under a load with the weight [N]."""
        self._operation = configuration, speed, load
        self._steady = QuasiSteady(configuration.model_copy(update={"faults": type(configuration.faults)()}))
        self._running: Running = self._steady.running(speed, load)

    @property
    def box(self) -> float:
        """Temperature of its box [deg C]."""
        return self._temperatures[self._steady.network.box]

    @property
    def outer_ring(self) -> float:
        """Temperature of its outer ring [deg C]."""
        return self._temperatures[self._steady.network.outer(0)]

    def follow(self, configuration: Configuration, speed: float, force: float, duration: float) -> None:
        """Follow the shaft's speed [rad/s] and the force of its load [N] over a duration [s] of simulated time."""
        self._elapsed += duration
        if self._elapsed < PERIOD:
            return
        heated, self._elapsed = self._elapsed * configuration.thermal.acceleration, 0.0
        load = force + configuration.bearing.inner_ring_mass * configuration.operating.gravity
        operation = configuration, round(speed / SPEED_RESOLUTION) * SPEED_RESOLUTION, load
        if operation != self._operation:
            self._run(*operation)
        # Steps of a minute or less, in which the heat keeps its value; 20 longer ones with a time lapse above 1200.
        parts = min(max(1, round(heated / 60.0)), 20)
        for _ in range(parts):
            self._temperatures = self._steady.after(self._running, self._temperatures, heated / parts)

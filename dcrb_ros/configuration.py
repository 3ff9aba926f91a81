"""The whole configuration of a bench: read, checked once, explained when refused."""

from __future__ import annotations

from dcrb_ros.faults import Faults
from dcrb_ros.parameters import (
    Bearing,
    Cage,
    Contact,
    Friction,
    Group,
    Housing,
    Operating,
    Publishing,
    Recording,
    SensorParameters,
    SimulationParameters,
    quantity,
)


class Configuration(Group):
    """Everything a bench depends on; the samples follow from this and the simulated times of commands."""

    bearing: Bearing = Bearing()
    housing: Housing = Housing()
    contact: Contact = Contact()
    friction: Friction = Friction()
    cage: Cage = Cage()
    operating: Operating = Operating()
    faults: Faults = Faults()
    simulation: SimulationParameters = SimulationParameters()
    sensor: SensorParameters = SensorParameters()
    publishing: Publishing = Publishing()
    recording: Recording = Recording()
    time_scale: float = quantity(1.0, "-", "Simulated over wall time asked for; 0 for as fast as possible", 0.0, 1000.0)

    @property
    def steps_per_sample(self) -> int:
        """Time steps between two samples [-]."""
        return round(1.0 / (self.simulation.step * self.sensor.sampling_rate))

    @property
    def step_rate(self) -> int:
        """Time steps in a simulated second [Hz]."""
        return self.steps_per_sample * self.sensor.sampling_rate

"""All groups of parameters of a simulation, each valid by itself; `configuration` compares them with each other."""

from __future__ import annotations

from dcrb_ros.faults import Faults
from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.settings.contact import Contact, Friction, Lubrication
from dcrb_ros.settings.impacts import Impacts
from dcrb_ros.settings.parameters import (
    Bearing,
    Cage,
    Housing,
    Operating,
    Publishing,
    Recording,
    SimulationParameters,
    Surfaces,
)
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure, Tacho
from dcrb_ros.settings.thermal import Thermal


class ParameterGroups(Group):
    """The groups of a configuration, which the rules about several groups take."""

    bearing: Bearing = Bearing()
    housing: Housing = Housing()
    lubrication: Lubrication = Lubrication()
    thermal: Thermal = Thermal()
    surfaces: Surfaces = Surfaces()
    contact: Contact = Contact()
    friction: Friction = Friction()
    cage: Cage = Cage()
    operating: Operating = Operating()
    faults: Faults = Faults()
    impacts: Impacts = Impacts()
    simulation: SimulationParameters = SimulationParameters()
    structure: Structure = Structure()
    background: Background = Background()
    sensor: SensorParameters = SensorParameters()
    tacho: Tacho = Tacho()
    publishing: Publishing = Publishing()
    recording: Recording = Recording()
    time_scale: float = quantity(
        1.0,
        "-",
        "Requested ratio of simulated to wall time; 0 for as fast as possible",
        0.0,
        1000.0,
        remedy="give 0 for as fast as possible, 1 for real time",
        run_time=True,
    )

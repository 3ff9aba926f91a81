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
    Surfaces,
)
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure, Tacho
from dcrb_ros.settings.simulation import SimulationParameters
from dcrb_ros.settings.thermal import Thermal


class ParameterGroups(Group):
    """The groups of a configuration, which the rules about several groups take.

    The defaults are valid. To check each of them would compile each group once more by itself.
    """

    bearing: Bearing = Bearing.model_construct()
    housing: Housing = Housing.model_construct()
    lubrication: Lubrication = Lubrication.model_construct()
    thermal: Thermal = Thermal.model_construct()
    surfaces: Surfaces = Surfaces.model_construct()
    contact: Contact = Contact.model_construct()
    friction: Friction = Friction.model_construct()
    cage: Cage = Cage.model_construct()
    operating: Operating = Operating.model_construct()
    faults: Faults = Faults.model_construct()
    impacts: Impacts = Impacts.model_construct()
    simulation: SimulationParameters = SimulationParameters.model_construct()
    structure: Structure = Structure.model_construct()
    background: Background = Background.model_construct()
    sensor: SensorParameters = SensorParameters.model_construct()
    tacho: Tacho = Tacho.model_construct()
    publishing: Publishing = Publishing.model_construct()
    recording: Recording = Recording.model_construct()
    time_scale: float = quantity(
        1.0,
        "-",
        "Requested ratio of simulated to wall time; 0 for as fast as possible",
        0.0,
        1000.0,
        remedy="give 0 for as fast as possible, 1 for real time",
        run_time=True,
    )

"""Temperatures of bearing and axle box: the parameters of the thermal network, and the combinations that it refuses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from dcrb_ros.faults.condition import Condition
from dcrb_ros.schema.fields import Group, choice, quantity

MOST_ACCELERATION = 3000.0
"""Largest time lapse [-]: a step of the network is then one minute, in which oil and temperature still keep step."""


class Thermal(Group):
    """Temperatures of rings, rollers and axle box, which the friction of the oil makes; ``law: none`` ignores the other parameters."""

    law: Literal["none", "network"] = choice(
        "none", "Temperatures: none, the oil has lubrication.temperature, or network, a thermal network of rings, rollers and axle box"
    )
    ambient: float = quantity(20.0, "deg C", "Temperature of the surroundings", -40.0, 60.0, symbol="T_a", run_time=True)
    air_speed: float = quantity(
        0.0,
        "m/s",
        "Speed of the air; 0 for that of the vehicle, from the shaft's speed and operating.wheel_diameter",
        0.0,
        150.0,
        run_time=True,
    )
    exposure: float = quantity(0.4, "-", "Share of that speed that reaches the axle box; 0 for still air", 0.0, 1.0, run_time=True)
    sun: float = quantity(0.0, "W", "Heat that the axle box absorbs from the sun", 0.0, 1000.0, run_time=True)
    box_mass: float = quantity(60.0, "kg", "Mass of the axle box that stores heat", 0.1, 1e4)
    box_area: float = quantity(0.45, "m^2", "Surface of the axle box", 0.001, 100.0)
    box_size: float = quantity(0.33, "m", "Size of the axle box across the air", 0.005, 10.0)
    seal_torque: float = quantity(0.0637, "N m", "Friction torque of the seals of each row; it only heats", 0.0, 100.0)
    seat_restraint: float = quantity(
        0.0, "-", "Share of the outer ring's expansion that its seat prevents: 0 for a loose fit, 1 for a rigid cold seat", 0.0, 1.0
    )
    acceleration: float = quantity(
        1.0,
        "-",
        "Time lapse: heat is stored so many times faster than in reality, while speed, load and faults keep their time; for demonstrations",
        1.0,
        MOST_ACCELERATION,
    )
    start: Literal["warm", "cold"] = choice("warm", "Temperatures at the start: warm, those of steady running, or cold, ambient")
    grease_limit: float = quantity(
        0.0, "deg C", "Temperature above which the lubricant burns, a hundredth per kelvin and hour; 0 for never", 0.0, 400.0
    )
    sensor_lag: float = quantity(60.0, "s", "Time constant of the temperature sensor in the axle box", 0.01, 3600.0)
    sensor_noise: float = quantity(0.2, "K", "Standard deviation of a reading of temperature", 0.0, 20.0)
    sensor_resolution: float = quantity(0.5, "K", "Step of a reading of temperature; 0 for none", 0.0, 10.0)


def thermal_limits(thermal: Thermal, condition: Condition, lubrication: str, joint: str) -> Iterator[str]:
    """Yield a sentence for each reason why a law of ``lubrication`` gives no temperatures, and for the sun and each fault without effect.

    ``joint`` is that of rollers and cage.
    """
    heated, dry = thermal.law == "network", lubrication == "dry"
    if heated and dry:
        yield (
            "thermal.law = network takes its heat from the friction of an oil, and lubrication.law is dry: take lubrication.law = film, "
            "or thermal.law = none"
        )
    if thermal.sun > 0.0 and not heated:
        yield f"thermal.sun = {thermal.sun:g} W only heats, and thermal.law is none: take thermal.law = network"
    if condition.loss > 0.0 and dry:
        yield f"faults.lubrication.loss = {condition.loss:g} needs a lubricant, and lubrication.law is dry: take lubrication.law = film"
    if condition.seal_torque > 0.0 and not heated:
        yield f"faults.seal_rub.torque = {condition.seal_torque:g} N m only heats, and thermal.law is none: take thermal.law = network"
    if condition.oil_share > 0.0 and not (heated or lubrication == "film_with_cages"):
        yield (
            f"faults.overfilled.share = {condition.oil_share:g} only heats where lubrication.law is {lubrication}, and thermal.law "
            "is none: take thermal.law = network, or lubrication.law = film_with_cages"
        )
    if condition.oil_share > 0.0 and lubrication == "film_with_cages" and joint == "revolute":
        yield (
            f"faults.overfilled.share = {condition.oil_share:g} drags on free rollers where lubrication.law is film_with_cages, and "
            "cage.joint is revolute: take cage.joint = pocket, or lubrication.law = film with thermal.law = network"
        )

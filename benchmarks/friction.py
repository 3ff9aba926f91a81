"""The friction of the simulated bearing over that of SKF's model, over speed, load, temperature and lubricant, and the slip of its cages.

``python benchmarks/friction.py`` prints the tables of docs/results/realism.md. A run takes seconds, all of them some minutes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.laws.viscosity import kinematic_viscosity
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import cage_speed
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.text.markdown import table
from dcrb_ros.validation.friction_moment import friction_moment
from dcrb_ros.validation.oiled_bench import BORE, OUTSIDE

LUBRICANTS = ("grease", "vg100")
SPEEDS = (150, 300, 600, 1200, 1800, 2500)
"""Speeds [1/min]."""
LOADS = (20, 50, 100, 200)
"""Radial loads [kN]."""
TEMPERATURES = (20, 50, 70, 90)
"""Temperatures of the oil [deg C]."""
SETTLING, DURATION = 0.3, 0.4
"""Simulated time before the mean of the power, and of it [s]."""
POINTS = (
    *((rpm, 100, 60) for rpm in (300, 600, 1200, 1800)),
    *((1200, load, 60) for load in (5, 20, 50, 200)),
    *((1200, 100, temperature) for temperature in (40, 80)),
)
"""Speed [1/min], load [kN] and temperature [deg C] at which power and slip are printed, with grease."""


class Friction(NamedTuple):
    """Means of a run."""

    power: float
    """[W]"""
    by_skf: float
    """Of two single-row bearings, each under half the load [W]."""
    slip: Floats
    """Of the cage of each row [-]."""


def friction(lubricant: str, rpm: float, load: float, temperature: float, settling: float, duration: float) -> Friction:
    """Return the friction after a settling time, during a time [s]."""
    speed = rpm * math.pi / 30.0
    configuration = load_configuration(
        "healthy",
        (
            *("operating.speed_fluctuation=0.0", "operating.speed_ripple=0.0", "sensor.noise_density=0.0"),
            *(f"operating.speed={speed}", f"operating.load={load}"),
            *(f"lubrication.temperature={temperature}", f"lubrication.lubricant={lubricant}"),
        ),
    )
    simulation = Simulation(configuration)
    list(simulation.blocks(settling))
    before, angles = simulation.energy.drive, simulation._state.cage_position[:, 2].copy()
    list(simulation.blocks(duration))
    slip = 1.0 - (simulation._state.cage_position[:, 2] - angles) / duration / cage_speed(configuration, speed)
    viscosity = kinematic_viscosity(lubricant_of(dict(configuration.lubrication)), temperature)
    by_skf = 2.0 * speed * friction_moment(BORE, OUTSIDE, 0.5 * load, speed, viscosity)
    return Friction((simulation.energy.drive - before) / duration, by_skf, slip)


def ratio(lubricant: str, rpm: float, load: float, temperature: float) -> float:
    """Return the simulated friction over that of SKF [-]."""
    found = friction(lubricant, rpm, load, temperature, SETTLING, DURATION)
    return found.power / found.by_skf


def main() -> None:
    """Print power and slip at some points, and for each lubricant the range of the ratio over the loads."""
    rows = []
    for rpm, load, temperature in POINTS:
        found = friction("grease", rpm, 1e3 * load, temperature, 0.5, 2.0)
        slips = ", ".join(f"{100.0 * share:.2f}" for share in found.slip)
        rows.append((rpm, load, temperature, slips, f"{found.power:.0f}", f"{found.by_skf:.0f}", f"{found.power / found.by_skf:.2f}"))
    heads = ("speed rpm", "load kN", "temperature °C", "cage slip of row 1, row 2 %", "power W", "SKF W", "ratio")
    print(table(heads, rows), flush=True)
    for lubricant in LUBRICANTS:
        ranges = []
        for rpm in SPEEDS:
            ratios = [[ratio(lubricant, rpm, 1e3 * load, temperature) for load in LOADS] for temperature in TEMPERATURES]
            ranges.append((f"{rpm}", *(f"{min(each):.2f} to {max(each):.2f}" for each in ratios)))
        print(f"\n{lubricant}\n", table(("speed [rpm]", *(f"{t} deg C" for t in TEMPERATURES)), ranges), sep="\n", flush=True)


if __name__ == "__main__":
    main()

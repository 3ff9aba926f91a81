"""The friction moment of the simulated bearing over that of SKF's model, over speed, load, temperature and lubricant.

``python benchmarks/friction.py`` prints the tables of docs/results/realism.md: the ratio, and where the film is thin or SKF's bearing is
starved. A run takes two seconds, all of them some minutes.
"""

from __future__ import annotations

import math

from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.laws.viscosity import kinematic_viscosity
from dcrb_ros.settings.files import load_configuration
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


def ratio(lubricant: str, rpm: float, load: float, temperature: float) -> float:
    """Return the simulated friction moment over that of two single-row bearings by SKF, each under half the load [-]."""
    speed = rpm * math.pi / 30.0
    configuration = load_configuration(
        "healthy",
        (
            *("operating.speed_fluctuation=0.0", "operating.speed_ripple=0.0", "sensor.noise_density=0.0"),
            *(f"operating.speed={speed}", f"operating.load={load}"),
            *(f"lubrication.temperature={temperature}", f"lubrication.lubricant={lubricant}"),
        ),
    )
    blocks = Simulation(configuration).blocks(SETTLING + DURATION)
    accounts = [(block.end_ns * 1e-9, block.energy.drive) for block in blocks if block.energy]
    (start, before), (end, after) = next(each for each in accounts if each[0] >= SETTLING), accounts[-1]
    viscosity = kinematic_viscosity(lubricant_of(dict(configuration.lubrication)), temperature)
    return (after - before) / (end - start) / speed / (2.0 * friction_moment(BORE, OUTSIDE, 0.5 * load, speed, viscosity))


def main() -> None:
    """Print a table for each lubricant: the range of the ratio over the loads."""
    for lubricant in LUBRICANTS:
        rows = []
        for rpm in SPEEDS:
            ratios = [[ratio(lubricant, rpm, 1e3 * load, temperature) for load in LOADS] for temperature in TEMPERATURES]
            rows.append((f"{rpm}", *(f"{min(each):.2f} to {max(each):.2f}" for each in ratios)))
        print(f"\n{lubricant}\n", table(("speed [rpm]", *(f"{t} deg C" for t in TEMPERATURES)), rows), sep="\n", flush=True)


if __name__ == "__main__":
    main()

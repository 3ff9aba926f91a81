"""Comparisons of the lubricated bench: balances, friction by source, a starved layer, and the friction formulas of SKF and Palmgren.

Ranges without a formula are this model's own, from the shipped configuration; the mutation table in `docs/results/accuracy.md` shows
which changes of the bench they notice.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.laws.viscosity import kinematic_viscosity
from dcrb_ros.stream.states import FRICTION_SOURCES
from dcrb_ros.validation.friction_moment import friction_moment, palmgren_moment
from dcrb_ros.validation.oiled_runs import OiledRun, OiledRuns
from dcrb_ros.validation.report_row import ReportRow, about, between

CHAPTER, FRICTION_CHAPTER = "Oil film", "Friction"
BORE, OUTSIDE = 0.130, 0.250
"""Diameters of the default bearing, NJ(P)3226X1 [m]."""
MODEL_TOLERANCE = 0.4
"""Accepted relative difference from a friction formula [-]."""
PALMGREN_ENDS = (0.75, 2.0 / 3.0), (1.25, 4.0 / 3.0)
"""Ends of the ranges of f_0 and f_1 over their middles [-]: 0.6 to 1 of 0.8 with grease, 0.0002 to 0.0004 of 0.0003."""
POWERS = {
    "sliding": (61.0, 74.0),
    "rolling": (925.0, 960.0),
    "contacts": (0.3, 0.6),
    "pockets": (5.4, 7.4),
    "drag": (280.0, 320.0),
    "lands": (32.0, 38.0),
}
"""Accepted power of each source [W]; parts of a run scatter by a third as much."""
PRESSING = 0.25, 0.295
"""Accepted share of time in which a roller presses a bar [-]."""
LEVELS = {"healthy": (1.1, 1.28), "spall": (15.5, 17.8)}
"""Accepted root mean square of the vertical acceleration [m/s^2]."""


def oiled_bench_rows(runs: OiledRuns) -> Iterator[ReportRow]:
    """Yield the comparisons of the runs of lubricated bearings."""
    healthy, steady = runs["healthy"], runs["steady"]
    yield from balance_rows(steady)
    for source, limits in POWERS.items():
        yield between(CHAPTER, f"Power lost, {source}", float(healthy.power[FRICTION_SOURCES.index(source)]), *limits, "W")
    pressing = float((healthy.bar_force != 0.0).mean())
    yield between(CHAPTER, "Share of time in which a roller presses a bar", pressing, *PRESSING)
    for name, (low, high) in LEVELS.items():
        yield between(CHAPTER, f"Acceleration of the outer ring, vertical: RMS, {name}", float(runs[name].rms[1]), low, high, "m/s^2")
    yield from _slip(runs)
    yield from cold_rows(runs["cold start"])
    yield from _thin(runs["thin layer"], steady)
    yield from friction_rows(steady)


def balance_rows(steady: OiledRun) -> Iterator[ReportRow]:
    """Yield the comparisons of energies of a run at constant speed."""
    share = abs(steady.change.residual) / steady.change.drive
    yield between(CHAPTER, "Energy account at constant speed: residual over the work of the shaft", share, -math.inf, 1e-4)
    balance = float(steady.power.sum()) / steady.drive_power
    yield about(CHAPTER, "Power of all sources over that of the shaft at constant speed", balance, 1.0, 0.01)


def _slip(runs: OiledRuns) -> Iterator[ReportRow]:
    loaded, light = runs["steady"], runs["light load"]
    slips = [1.0 - float(run.cage_speed.mean()) / float(loaded.cage_speed.mean()) for run in (loaded, light)]
    yield between(CHAPTER, "Cages under 5 kN turn slower than under 100 kN by", slips[1], 0.03, 0.12)
    locked = max(float(np.nanmax(np.abs(state.loaded_slip))) for state in loaded.states)
    yield between(CHAPTER, "Largest slip of the most loaded rollers", locked, 2e-4, 1e-3, "m/s")


def cold_rows(run: OiledRun) -> Iterator[ReportRow]:
    """The shaft turns at full speed under rollers at rest: their film slides at its limiting stress, 0.05 to 0.08 of the pressure."""
    traction = max(float(np.nanmax(np.abs(state.loaded_traction))) for state in run.states)
    yield between(CHAPTER, "Largest traction coefficient as a cold bearing starts, of mineral oils", traction, 0.05, 0.08)


def _thin(thin: OiledRun, thick: OiledRun) -> Iterator[ReportRow]:
    """A layer of 1 um instead of 5 um starves the contacts: less resistance, thinner films."""
    at = FRICTION_SOURCES.index("rolling")
    yield between(CHAPTER, "Power of rolling with a layer of 1 um over that with 5 um", float(thin.power[at] / thick.power[at]), 0.2, 0.5)
    films = [float(np.mean([state.least_film for state in run.states])) for run in (thin, thick)]
    yield about(CHAPTER, "Films of them, mean of both raceways", 1e6 * np.array(films), (0.706, 1.009), 0.02, "um")


def friction_rows(run: OiledRun) -> Iterator[ReportRow]:
    """Yield the comparisons of the friction with the formulas for two single-row bearings."""
    operating, oil = run.configuration.operating, run.configuration.lubrication
    viscosity = kinematic_viscosity(lubricant_of(dict(oil)), oil.temperature)
    given = BORE, OUTSIDE, 0.5 * operating.load, operating.speed, viscosity
    torque = run.drive_power / operating.speed
    yield about(
        FRICTION_CHAPTER, "Friction torque of both rows by SKF, steady", torque, 2.0 * friction_moment(*given), MODEL_TOLERANCE, "N m"
    )
    viscous = palmgren_moment(BORE, OUTSIDE, 0.0, operating.speed, viscosity, oil.lubricant)
    by_load = palmgren_moment(*given, oil.lubricant) - viscous
    least, most = (2.0 * (factors[0] * viscous + factors[1] * by_load) for factors in PALMGREN_ENDS)
    limits = (1.0 - MODEL_TOLERANCE) * least, (1.0 + MODEL_TOLERANCE) * most
    yield between(FRICTION_CHAPTER, "The same by Palmgren, the ends of his factors and 40 % beyond", torque, *limits, "N m")

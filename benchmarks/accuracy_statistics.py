"""Accuracy: statistics of an outer ring defect over seconds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from accuracy_table import STEP, Entry, print_table, step_name
from accuracy_waveform import outer_defect

from dcrb_ros.bearing.observation import wrapped
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.measures import envelope_spectrum, kurtosis

SPAN = 3.0
LEFT_OUT = 0.2
LINE_WIDTH = 2.0
"""Search range to either side of 16 f_c [Hz]."""
MOST_SIZE, MOST_RATE = 0.05, 0.005
"""Relative tolerances of rms, kurtosis and line amplitude, and of line frequency and cage speed [-]."""
LOAD, NEARBY = 100000.0, 100000.001
"""A load [N], and one that differs by 1e-8, to show the scatter due to chaotic motion."""


class Statistics(NamedTuple):
    """Statistics of the vertical acceleration without noise, and of the cages."""

    rms: float
    """[m/s^2]."""
    kurtosis: float
    line_frequency: float
    """Frequency of the largest envelope line near 16 f_c [Hz]."""
    line_amplitude: float
    """[m/s^2]."""
    cage_speed: float
    """Mean rotation speed of the cages [rad/s]."""
    rows_apart: float
    """Largest angle between the cages [rad]."""


def statistics_of(configuration: Configuration) -> Statistics:
    """Return the statistics of a run."""
    blocks = list(Simulation(configuration).blocks(SPAN))
    rate, bearing = configuration.sensor.sampling_rate, configuration.bearing
    y = np.concatenate([block.clean for block in blocks])[round(LEFT_OUT * rate) :, 1].astype(np.float64)
    states = [states for block in blocks for states in block.states]
    rollers = bearing.rows * bearing.rollers_per_row
    cages = slice(rollers, rollers + bearing.rows)
    speed = float(np.mean([at.speed[cages] for at in states if at.time_ns >= LEFT_OUT * 1e9]))
    apart = wrapped(np.array([np.ptp(at.azimuth[cages]) for at in states]))
    line = envelope_spectrum(y, rate).line(bearing.rollers_per_row * speed / (2.0 * math.pi), LINE_WIDTH)
    return Statistics(float(y.std()), kurtosis(y), line.frequency, line.amplitude, speed, float(np.abs(apart).max()))


def statistics_entry(case: str, part: int, found: Statistics, exact: Statistics, held: bool) -> Entry:
    """Return a row of `statistics`: every value with its deviation from the exact one; it has a verdict if ``held``."""
    errors = [value / true - 1.0 for value, true in zip(found[:5], exact[:5], strict=True)]
    values = (f"{value:.5g} ({100.0 * error:+.2f} %)" for value, error in zip(found[:5], errors, strict=True))
    sizes, rates = (errors[0], errors[1], errors[3]), (errors[2], errors[4])
    within = max(map(abs, sizes)) <= MOST_SIZE and max(map(abs, rates)) <= MOST_RATE
    return Entry((case, step_name(part), *values, f"{math.degrees(found.rows_apart):.3f}"), within if held else None)


def statistics() -> Iterator[Entry]:
    """Yield the statistics for three steps, and for a slightly different load."""
    for case, joint, row in (("revolute", "revolute", None), ("pocket", "pocket", None), ("pocket, defect in one row", "pocket", 1)):

        def run(part: int, load: float = LOAD, joint: str = joint, row: int | None = row) -> Statistics:
            return statistics_of(outer_defect(joint, STEP / part, load, row))

        exact = run(4)
        yield statistics_entry(case, 4, exact, exact, False)
        for part in (2, 1):
            yield statistics_entry(case, part, run(part), exact, True)
        yield statistics_entry(f"{case}, load + 1e-8", 1, run(1, NEARBY), exact, False)


def statistics_table() -> bool:
    """Print the statistics over seconds."""
    units = ("rms [m/s^2]", "kurtosis [-]", "line [Hz]", "line [m/s^2]", "cage speed [rad/s]")
    tolerance = (
        f"{SPAN:g} s with the default step h compared with h/4: rms, kurtosis and line amplitude within {100.0 * MOST_SIZE:g} %, "
        f"line frequency and cage speed within {100.0 * MOST_RATE:g} %. Rows in phase start identically and stay so, so their rollers "
        "strike together. Any difference lets free rows drift apart, and rms and kurtosis depend on the angle between them."
    )
    heads = ("case", "step", *units, "rows apart [deg]")
    return print_table("Outer ring defect, statistics", tolerance, heads, statistics())
